// SPDX-License-Identifier: Apache-2.0
// A source read to its end: samples by the names of channels and fields, and what it reported.
#pragma once

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../plugins/bind.hpp"
#include "binnacle/source.hpp"
#include "binnacle/testing.hpp"

namespace binnacle::test {

/// A folder that is removed with it.
class Folder {
 public:
  Folder() {
    // In memory where there is such a file system: mutations are many files.
    const std::filesystem::path memory = "/dev/shm";
    const auto parent = std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
    std::string pattern = (parent / "binnacle_readers_XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return file(name);
  }

 private:
  std::filesystem::path path_;
};

inline std::string bytes_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class Reports final : public Reporter {
 public:
  void warn(const std::string& code, const std::string& file, int line, const std::string& text) override {
    all +=
        code + " " + std::filesystem::path(file).filename().string() + ":" + std::to_string(line) + " " + text + "\n";
  }
  std::string all;
};

struct Sample {
  std::string channel;  // "" : the source's own
  Time t = no_time, t0 = no_time;
  std::map<std::string, double> fields;
  std::vector<std::map<std::string, double>> rows;
  std::vector<double> covariance;

  double operator[](const std::string& name) const { return fields.at(name); }
};

/// Everything that a source emits, read as the kernel does it; of a live one what is there so far.
template <class SourceType>
struct Recorded {
  std::string reports;
  std::vector<Sample> samples;

  explicit Recorded(const nlohmann::json& parameters) {
    const auto source = bind<SourceType>({parameters, {}, {}});
    Reports collected;
    try {
      source->open(collected);
    } catch (...) {
      reports = collected.all;
      throw;
    }
    read(*source);
    reports = collected.all;  // a live one reports while it is read
  }
  std::vector<Sample> of(const std::string& channel) const {
    std::vector<Sample> list;
    for (const Sample& sample : samples)
      if (sample.channel == channel) list.push_back(sample);
    return list;
  }
  bool has_reported(const std::string& text) const { return reports.find(text) != std::string::npos; }

 private:
  void read(const Source& source) {
    const binnacle::testing::SourceCaller caller(source);
    auto memory = caller.fresh_memory(0);
    Time last = no_time;
    for (auto next = caller.next(memory.data()); next.status == SourceStatus::sample;
         next = caller.next(memory.data())) {
      if (!next.damage.empty()) throw std::logic_error(next.damage);
      if (!source.declaration().live && last != no_time && next.sample.t < last)
        throw std::logic_error("goes back in time");
      last = next.sample.t;
      samples.push_back(
          named(source.declaration().channels.at(static_cast<std::size_t>(next.sample.channel)), next.sample));
    }
  }
  template <class Emitted>
  static Sample named(const ChannelDeclaration& channel, const Emitted& emitted) {
    Sample sample{channel.name, emitted.t, emitted.t0, {}, {}, emitted.covariance};
    sample.rows.resize(static_cast<std::size_t>(emitted.rows));
    std::size_t epoch = 0, row = 0;
    const auto width = static_cast<std::size_t>(channel.count(true));
    for (const FieldSpec& field : channel.fields) {
      if (!field.is_per_row) {
        sample.fields[field.name] = emitted.fields.at(epoch++);
        continue;
      }
      for (std::size_t i = 0; i < sample.rows.size(); ++i)
        sample.rows[i][field.name] = emitted.row_fields.at(i * width + row);
      ++row;
    }
    return sample;
  }
};

}  // namespace binnacle::test
