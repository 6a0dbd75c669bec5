// SPDX-License-Identifier: Apache-2.0
// Files of the tests of csv: written, read back, their faults in words.
#pragma once

#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"

#include <stdlib.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "csv/csv_source.hpp"
#include "json_members.hpp"

namespace binnacle::csv_files {

using namespace binnacle::json_members;
using binnacle::csv::CsvSource;

/// A file of its own in a folder that goes with it.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& content, const std::string& name = "data.csv") {
    std::string pattern = (std::filesystem::temp_directory_path() / "binnacle_csv_").string() + std::string(6, 'X');
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    folder_ = pattern;
    path_ = (folder_ / name).string();
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~TemporaryFile() { std::filesystem::remove_all(folder_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/// As one gzip member.
inline std::string gzipped(const std::string& content) {
  z_stream z{};
  REQUIRE(deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&z, content.size()) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  z.avail_in = static_cast<uInt>(content.size());
  z.next_out = reinterpret_cast<Bytef*>(packed.data());
  z.avail_out = static_cast<uInt>(packed.size());
  REQUIRE(deflate(&z, Z_FINISH) == Z_STREAM_END);
  packed.resize(z.total_out);
  deflateEnd(&z);
  return packed;
}

struct Warning {
  std::string code, file;
  int line;
  std::string message;
};

class Warnings : public Reporter {
 public:
  void warn(const std::string& code, const std::string& file, int line, const std::string& message) override {
    all.push_back({code, file, line, message});
  }
  std::vector<Warning> all;
};

struct Sample {
  Time t, t0;
  std::vector<double> fields;
};

inline Json column(const std::string& name, const std::string& of_unit = "1", const std::string& kind = "level") {
  return object({{"column", name}, {"unit", of_unit}, {"kind", kind}});
}

/// Time in the first column, seconds; fields as given.
inline Json parameters(const std::string& path, const Members& columns) {
  return object({{"path", path}, {"columns", object(columns)}});
}

inline Json rate_and_level(const std::string& path) {
  return parameters(path, {{"w", column("w", unit("rad/s"), "rate")}, {"a", column("a", unit("m"))}});
}

inline std::vector<Sample> read(const Json& value, Warnings* warnings = nullptr) {
  const auto bound = binnacle::testing::bind<CsvSource>({value});
  CsvSource& source = *bound;
  Warnings own;
  source.open(warnings ? *warnings : own);
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(1);
  std::vector<Sample> samples;
  for (;;) {
    const auto next = caller.next(memory.data());
    REQUIRE(next.damage.empty());
    if (next.status != SourceStatus::sample) {
      REQUIRE(next.status == SourceStatus::end);
      return samples;
    }
    REQUIRE(next.sample.channel == 0);
    samples.push_back({next.sample.t, next.sample.t0, next.sample.fields});
  }
}

inline std::vector<Sample> read_text(const std::string& content) {
  const TemporaryFile file(content);
  return read(rate_and_level(file.path()));
}

/// The fault, as "CODE line N: message", or "pointer: message" for one of the configuration.
inline std::string fault_of(const Json& value) {
  try {
    read(value);
  } catch (const ComponentError& error) {
    if (!error.is_data_error()) return error.pointer() + ": " + error.what();
    return error.code() + " line " + std::to_string(error.line()) + ": " + error.what();
  }
  return "no fault";
}

inline std::string fault_of_text(const std::string& content) {
  const TemporaryFile file(content);
  return fault_of(rate_and_level(file.path()));
}

}  // namespace binnacle::csv_files
