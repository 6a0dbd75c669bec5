// SPDX-License-Identifier: Apache-2.0
// RunRecorder: what a run leaves in a folder: run.nc, what it estimates as one CSV file per filter, the report's page.
#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atomic_file.hpp"
#include "csv_records.hpp"
#include "folder_lock.hpp"
#include "output.hpp"
#include "record_formats.hpp"
#include "report/recorded_run.hpp"
#include "results/run_writer.hpp"
#include "score/run.hpp"
#include "step_observers.hpp"

namespace binnacle::command {

/// FOLDER/run.nc: as results/run_writer.hpp has it. FOLDER/FILTER.csv: as csv_records.hpp has it. They are written on a thread of
/// their own, a block of rows at a time; the run waits for it only where several blocks wait already. Nothing is seen of
/// the files before commit().
class RunRecorder {
 public:
  /// Makes the folder. Throws UsageError when nothing can be written there; everything else throws OutputError.
  RunRecorder(std::filesystem::path folder, const Composition& composition, const Json& provenance,
              const RecordFormats& formats = {});
  /// Leaves nothing behind that was not committed, the folder included if it was made here.
  ~RunRecorder();
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns);
  void record(int filter, Time t, std::span<const double> values);
  /// Null: nothing is kept of what became of samples.
  StepObserver* step_observer(int filter);
  void scored(int filter, const score::ErrorSeries& errors);
  /// Puts the records, config.json and then summary.json in place: with summary.json there, all data are; the page follows.
  void commit(const Json& summary, const Json& config);

 private:
  /// Rows that come, until they make a block.
  struct Filter {
    std::filesystem::path csv_path;
    std::unique_ptr<CsvRecords> csv;
    std::size_t columns = 0, rows_of_block = 1;
    std::unique_ptr<results::RowBlock> open;
  };

  template <class Action>
  void guarded(Action&& action);
  std::unique_ptr<results::RowBlock> empty_block();
  void send(std::size_t filter);
  void write(std::size_t filter, const results::RowBlock& rows);
  void remove_earlier() const;
  void write_page(const Json& summary, const Json& config);

  std::filesystem::path folder_;
  std::filesystem::path made_;  // topmost folder that was made; empty: none
  RecordFormats formats_;
  Json provenance_;
  std::optional<Unfinished> unfinished_;
  std::optional<FolderLock> lock_;
  std::unique_ptr<AtomicFile> config_, summary_, netcdf_file_;
  std::unique_ptr<results::RunWriter> netcdf_;
  std::unique_ptr<report::RecordedRun> page_;
  std::deque<Filter> filters_;
  std::deque<StepObservers> observers_;
  std::mutex spare_mutex_;
  std::vector<std::unique_ptr<results::RowBlock>> spare_;  // to be filled again
  results::ColumnBlock column_block_;                      // of the writer's thread
  std::optional<results::WriterThread> thread_;            // ends before what it writes to
};

}  // namespace binnacle::command
