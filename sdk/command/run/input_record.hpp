// SPDX-License-Identifier: Apache-2.0
// What arrived in a run, as text that another run reads in place of its sources, to the same bits.
#pragma once

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "binnacle/run.hpp"

namespace binnacle::command {

/// A line for each sample, in order of arrival, as JSON: "channel", "arrival" [ns of the run], "n" (its sequence), "t" and "t0"
/// [ns], "fields" [SI], "rows", "covariance"; one with an arrival alone is an instant without a sample. The first line names the format and the channels' fields. Numbers are the
/// shortest that are read as the same double; null is NaN. What was written is on disk a second later, whatever
/// happens to the process.
class InputWriter {
 public:
  /// Throws UsageError where the file cannot be made.
  InputWriter(const std::string& path, const Composition& composition);
  void write(const Arrival& arrival);
  /// Throws OutputError: not all could be written.
  void close();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void append_sample(const Arrival& arrival);
  void append_list(const double* numbers, std::size_t count);

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  struct Channel {
    std::string begin;                                       // of its lines
    std::size_t fields = 0, row_fields = 0, covariance = 0;  // numbers; error components
  };
  std::vector<Channel> channels_;
  std::string line_;
  Time flushed_ = 0;
  int error_ = 0;
};

/// Reads it. Samples with the same arrival make one instant.
class InputReader final : public RecordedInput {
 public:
  /// Throws DataError where the file is none of these, or of channels that the composition does not have so.
  InputReader(const std::string& path, const Composition& composition);
  bool next_instant() override;
  const Arrival* next() override;
  /// Where the file was cut short, what is whole was read: a warning says so. Empty: it was not.
  std::string warning() const;

 private:
  struct Sample {
    int channel = -1;
    std::int64_t sequence = 0;
    Time arrival = 0, t = 0, t0 = no_time;
    int rows = 0;
    std::vector<double> fields, row_fields, covariance;
  };
  bool read(Sample& sample);
  void check_head();
  [[noreturn]] void fail(const std::string& why) const;

  std::string path_;
  const Composition& composition_;
  std::ifstream file_;
  std::int64_t line_ = 0;
  Sample ready_, taken_;
  SampleView view_;
  Arrival given_;
  Time instant_ = 0;  // its arrival
  bool has_ready_ = false, is_cut_ = false;
};

}  // namespace binnacle::command
