// SPDX-License-Identifier: Apache-2.0
// What reading_bench.py runs: `reading_bench source|fast_float FILE` prints the seconds of processor that it takes to read all
// samples of a csv file, or all of its numbers by fast_float alone, and what they add up to.
#include <ctime>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/bind.hpp"
#include "csv/csv_source.hpp"

#if __has_include(<fast_float/fast_float.h>)
#include <fast_float/fast_float.h>
#define HAS_FAST_FLOAT 1
#endif

using namespace binnacle;

namespace {

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct NoReports : Reporter {
  void warn(const std::string&, const std::string&, int, const std::string& message) override {
    throw std::runtime_error(message);
  }
};

double sum_by_source(const std::string& path) {
  nlohmann::ordered_json columns;
  for (const char* name : {"wx", "wy", "wz", "fx", "fy", "fz"})
    columns[name] = {{"column", name}, {"unit", "1"}, {"kind", "rate"}};
  const auto bound = testing::bind<csv::CsvSource>({nlohmann::ordered_json{{"path", path}, {"columns", columns}}});
  csv::CsvSource& source = *bound;
  NoReports reports;
  source.open(reports);
  std::uint64_t next = 0;
  double fields[6] = {}, sum = 0;
  SampleWriter writer;
  writer.fields = fields;
  writer.field_count = 6;
  SourceOutput out(&writer);
  while (source.next(MemoryView(reinterpret_cast<std::byte*>(&next)), out) == SourceStatus::sample)
    for (const double each : fields) sum += each;
  return sum;
}

double sum_by_fast_float([[maybe_unused]] const std::string& path) {
#ifdef HAS_FAST_FLOAT
  std::ifstream file(path, std::ios::binary);
  std::string content(std::istreambuf_iterator<char>(file), {});
  const char* at = content.data() + content.find('\n') + 1;
  const char* const end = content.data() + content.size();
  double sum = 0, value = 0;
  const double begin = processor_s();
  for (bool is_time = true; at < end; ++at) {
    at = fast_float::from_chars(at, end, value).ptr;
    if (!is_time) sum += value;
    is_time = at < end && *at == '\n';
  }
  std::printf("%.6f %.17g\n", processor_s() - begin, sum);
  return sum;
#else
  throw std::runtime_error("built without fast_float (Debian package libfast-float-dev)");
#endif
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw std::invalid_argument("reading_bench source|fast_float FILE");
  if (std::string(argv[1]) == "fast_float") return sum_by_fast_float(argv[2]), 0;
  const double begin = processor_s();
  const double sum = sum_by_source(argv[2]);
  std::printf("%.6f %.17g\n", processor_s() - begin, sum);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "reading_bench: %s\n", error.what());
  return 1;
}
