// SPDX-License-Identifier: Apache-2.0
#include "run_recorder.hpp"

#include <cctype>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "folders.hpp"
#include "report_file.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

/// A filter's name is any JSON key; what a file name cannot have, or hides, becomes %2F and the like.
std::string file_name(const std::string& filter) {
  std::string name;
  for (const char c : filter) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain =
        byte >= 0x80 || std::isalnum(byte) || c == '_' || c == '-' || c == ' ' || (c == '.' && !name.empty());
    name += is_plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return name + ".csv";
}

/// RFC 4180: quotes around what has a comma or quotes in it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string seconds_text(Time t) {
  // The magnitude as unsigned: the smallest Time has no negative.
  const auto magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  return fmt::format("{}{}.{:09}", t < 0 ? "-" : "", magnitude / 1'000'000'000, magnitude % 1'000'000'000);
}

template <class Action>
void RunRecorder::write_netcdf(Action&& action) {
  try {
    action();
  } catch (const results::WriteError& error) {
    netcdf_file_->fail(error.what());
  }
}

RunRecorder::RunRecorder(fs::path folder, const Composition& composition, const Json& provenance)
    : folder_(std::move(folder).lexically_normal()) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();
  made_ = make_folders(folder_);
  if (!made_.empty()) unfinished_.emplace(folder_, made_);
  try {
    config_ = std::make_unique<AtomicFile>(folder_ / "config.json");
    summary_ = std::make_unique<AtomicFile>(folder_ / "summary.json");
    netcdf_file_ = std::make_unique<AtomicFile>(folder_ / "run.nc", AtomicFile::Temporary::named);
    write_netcdf(
        [&] { netcdf_ = std::make_unique<results::RunWriter>(netcdf_file_->path(), composition, provenance); });
  } catch (const std::runtime_error&) {
    netcdf_file_.reset();
    config_.reset();
    summary_.reset();
    if (!made_.empty()) remove_empty_folders(folder_, made_);
    throw;
  }
}

RunRecorder::~RunRecorder() {
  filters_.clear();
  netcdf_.reset();
  netcdf_file_.reset();
  config_.reset();
  summary_.reset();
  if (!made_.empty()) remove_empty_folders(folder_, made_);
}

void RunRecorder::begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) {
  const auto index = static_cast<std::size_t>(filter);
  if (filters_.size() <= index) filters_.resize(index + 1);
  filters_[index] = std::make_unique<AtomicFile>(folder_ / file_name(name));
  std::string header = "t[s]";
  for (const auto& column : columns)
    header += "," + cell(column.unit.empty() ? column.name : fmt::format("{}[{}]", column.name, column.unit));
  filters_[index]->write(header + "\n");
  write_netcdf([&] { netcdf_->begin(filter, name, columns); });
}

void RunRecorder::record(int filter, Time t, std::span<const double> values) {
  line_ = seconds_text(t);
  for (const double value : values) fmt::format_to(std::back_inserter(line_), ",{}", value);
  line_ += '\n';
  filters_[static_cast<std::size_t>(filter)]->write(line_);
  write_netcdf([&] { netcdf_->record(filter, t, values); });
}

void RunRecorder::scored(int filter, const score::ErrorSeries& errors) {
  write_netcdf([&] { netcdf_->scored(filter, errors); });
}

void RunRecorder::commit(const Json& summary, const Json& config) {
  config_->write(config.dump(2) + "\n");
  summary_->write(summary.dump(2) + "\n");
  write_netcdf([&] { netcdf_->close(); });
  std::error_code ignored;
  fs::remove(summary_->target(), ignored);  // an earlier run's: its records are about to go
  fs::remove(report_in(folder_), ignored);
  for (const auto& filter : filters_) filter->commit();
  netcdf_file_->commit();
  config_->commit();
  summary_->commit();
}

}  // namespace binnacle::command
