// SPDX-License-Identifier: Apache-2.0
// Benchmarks whose medians are compared with one another.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

/// Remembers the median of each benchmark's repetitions, in processor time: on a shared machine the wall clock counts
/// the neighbours.
class MedianReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const auto& run : runs)
      if (run.aggregate_name == "median") time_ns[run.run_name.str()] = run.GetAdjustedCPUTime();
  }
  std::map<std::string, double> time_ns;
};

/// Repeated and interleaved, so that a change of the processor's clock meets both sides of a ratio. False: an argument is
/// unknown.
inline bool run_interleaved(int argc, char** argv, MedianReporter& reporter) {
  std::vector<char*> arguments(argv, argv + argc);
  std::string defaults[] = {"--benchmark_repetitions=11", "--benchmark_enable_random_interleaving=true",
                            "--benchmark_display_aggregates_only=true", "--benchmark_min_time=0.02"};
  for (auto& option : defaults) arguments.insert(arguments.begin() + 1, option.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return false;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return true;
}
