// SPDX-License-Identifier: Apache-2.0
#include "run_recorder.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <utility>

#include "folders.hpp"
#include "other_results.hpp"
#include "report_file.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

/// Of an earlier run into the folder, perhaps of another config, by its summary.
std::vector<std::string> filters_in(const fs::path& summary) {
  std::vector<std::string> names;
  std::ifstream file(summary);
  const Json json = Json::parse(file, nullptr, false);
  if (!json.is_object() || !json.contains("filters") || !json["filters"].is_object()) return names;
  for (const auto& [name, figures] : json["filters"].items()) names.push_back(name);
  return names;
}

}  // namespace

/// What the writer of run.nc throws, on either thread, in the words of its file.
template <class Action>
void RunRecorder::guarded(Action&& action) {
  try {
    action();
  } catch (const results::WriteError& error) {
    netcdf_file_->fail(error.what());
  }
}

RunRecorder::RunRecorder(fs::path folder, const Composition& composition, const Json& provenance,
                         const RecordFormats& formats)
    : folder_(std::move(folder).lexically_normal()), formats_(formats), provenance_(provenance) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();
  made_ = make_folders(folder_);
  if (!made_.empty()) unfinished_.emplace(folder_, made_);
  try {
    lock_.emplace(folder_);
    config_ = std::make_unique<AtomicFile>(folder_ / "config.json");
    summary_ = std::make_unique<AtomicFile>(folder_ / "summary.json");
    thread_.emplace();
    observers_.resize(score::filters_of(composition).size());
    if (formats_.nc) {
      netcdf_file_ = std::make_unique<AtomicFile>(folder_ / "run.nc", AtomicFile::Temporary::named);
      guarded([&] {
        netcdf_ = std::make_unique<results::RunWriter>(netcdf_file_->path(), composition, provenance,
                                                       formats_.compression, *thread_);
      });
    }
    if (formats_.page) page_ = std::make_unique<report::RecordedRun>(composition);
    for (std::size_t f = 0; f < observers_.size(); ++f) {
      if (netcdf_) observers_[f].add(netcdf_->step_observer(static_cast<int>(f)));
      if (page_) observers_[f].add(page_->step_observer(static_cast<int>(f)));
    }
  } catch (...) {
    netcdf_file_.reset();
    config_.reset();
    summary_.reset();
    lock_.reset();
    if (!made_.empty()) remove_empty_folders(folder_, made_);
    throw;
  }
}

RunRecorder::~RunRecorder() {
  thread_.reset();
  filters_.clear();
  netcdf_.reset();
  netcdf_file_.reset();
  config_.reset();
  summary_.reset();
  lock_.reset();
  if (!made_.empty()) remove_empty_folders(folder_, made_);
}

void RunRecorder::begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) {
  const auto index = static_cast<std::size_t>(filter);
  if (filters_.size() <= index) filters_.resize(index + 1);
  Filter& its = filters_[index];
  its.columns = columns.size();
  its.rows_of_block = results::rows_of_block(columns.size());
  its.csv_path = folder_ / csv_name(name);
  if (formats_.csv) its.csv = std::make_unique<CsvRecords>(its.csv_path, columns);
  if (netcdf_) netcdf_->begin(filter, columns);
}

void RunRecorder::record(int filter, Time t, std::span<const double> values) {
  Filter& its = filters_[static_cast<std::size_t>(filter)];
  if (!its.open) its.open = empty_block();
  results::RowBlock& open = *its.open;
  open.t.push_back(t);
  open.values.insert(open.values.end(), values.begin(), values.end());
  open.values.resize(open.t.size() * its.columns, std::numeric_limits<double>::quiet_NaN());
  if (open.rows() == its.rows_of_block) send(static_cast<std::size_t>(filter));
}

/// One that was written already, whose memory is there.
std::unique_ptr<results::RowBlock> RunRecorder::empty_block() {
  const std::lock_guard lock(spare_mutex_);
  if (spare_.empty()) return std::make_unique<results::RowBlock>();
  auto block = std::move(spare_.back());
  spare_.pop_back();
  return block;
}

void RunRecorder::send(std::size_t filter) {
  Filter& its = filters_[filter];
  if (!its.open) return;
  const std::size_t bytes = its.open->bytes();
  const auto block = std::make_shared<std::unique_ptr<results::RowBlock>>(std::move(its.open));
  guarded([&] {
    thread_->post(bytes, [this, filter, block] {
      write(filter, **block);
      (*block)->t.clear();
      (*block)->values.clear();
      const std::lock_guard lock(spare_mutex_);
      spare_.push_back(std::move(*block));
    });
  });
}

/// By the writer's thread.
void RunRecorder::write(std::size_t filter, const results::RowBlock& rows) {
  Filter& its = filters_[filter];
  if (its.csv) its.csv->write(rows);
  if (!netcdf_ && !page_) return;
  column_block_.take(rows, its.columns);
  if (netcdf_) {
    netcdf_->write(static_cast<int>(filter), column_block_);
    netcdf_file_->start_write_out();
  }
  if (page_) page_->take(static_cast<int>(filter), column_block_);
}

StepObserver* RunRecorder::step_observer(int filter) { return observers_[static_cast<std::size_t>(filter)].joined(); }

void RunRecorder::scored(int filter, const score::ErrorSeries& errors) {
  if (netcdf_) guarded([&] { netcdf_->scored(filter, errors); });
  if (page_) page_->scored(filter, errors);
}

/// What would be taken for this run's.
void RunRecorder::remove_earlier() const {
  std::error_code ignored;
  for (const auto& name : filters_in(summary_->target()))
    if (std::ranges::none_of(filters_, [&](const Filter& its) { return its.csv_path == folder_ / csv_name(name); }))
      fs::remove(folder_ / csv_name(name), ignored);
  fs::remove(summary_->target(), ignored);  // its records are about to go
  fs::remove(report_in(folder_), ignored);
  if (!formats_.nc) fs::remove(folder_ / "run.nc", ignored);
  if (formats_.csv) return;
  for (const auto& filter : filters_) fs::remove(filter.csv_path, ignored);
}

void RunRecorder::commit(const Json& summary, const Json& config) {
  config_->write(config.dump(2) + "\n");
  summary_->write(summary.dump(2) + "\n");
  for (std::size_t f = 0; f < filters_.size(); ++f) send(f);
  guarded([&] {
    if (netcdf_) netcdf_->close();
    thread_->finish();
  });
  thread_.reset();  // all is done; the page needs the memory
  netcdf_.reset();
  spare_.clear();
  column_block_ = {};
  for (const auto& filter : filters_)
    if (filter.csv) filter.csv->complete();
  if (netcdf_file_) netcdf_file_->complete();
  config_->complete();
  summary_->complete();
  remove_earlier();
  for (const auto& filter : filters_)
    if (filter.csv) filter.csv->commit();
  if (netcdf_file_) netcdf_file_->commit();
  config_->commit();
  summary_->commit();
  write_page(summary, config);
}

/// Beside the run's, a study's that is in the same folder.
void RunRecorder::write_page(const Json& summary, const Json& config) {
  std::optional<results::StudyResults> study;
  try {
    study = results::read_study(folder_);
  } catch (const std::runtime_error& error) {
    if (page_) throw OutputError(error.what());  // without a page, who reads the study reports it
  }
  if (study) name_other_study(folder_, study->config, config);
  if (!page_) return;
  command::write_page(page_->page(summary, config, provenance_, std::move(study)), report_in(folder_));
}

}  // namespace binnacle::command
