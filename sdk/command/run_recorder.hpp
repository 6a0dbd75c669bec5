// SPDX-License-Identifier: Apache-2.0
// RunRecorder: what a run leaves in a folder: run.nc, and what it estimates as one CSV file per filter.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atomic_file.hpp"
#include "output.hpp"
#include "results/run_writer.hpp"
#include "score/run.hpp"

namespace binnacle::command {

/// FOLDER/run.nc: as results/run_writer.hpp has it. FOLDER/FILTER.csv: one header row, "t[s],position.lat[rad],…,position.lat.sigma[rad],…"; SI numbers that read back
/// exactly; times in seconds to the nanosecond. Nothing is seen of the files before commit().
class RunRecorder {
 public:
  /// Makes the folder. Throws UsageError when nothing can be written there; everything else throws OutputError.
  RunRecorder(std::filesystem::path folder, const Composition& composition, const Json& provenance);
  /// Leaves nothing behind that was not committed, the folder included if it was made here.
  ~RunRecorder();
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns);
  void record(int filter, Time t, std::span<const double> values);
  StepObserver* step_observer(int filter) { return netcdf_->step_observer(filter); }
  void scored(int filter, const score::ErrorSeries& errors);
  /// Puts the records, config.json and at last summary.json in place: with summary.json there, all of it is.
  void commit(const Json& summary, const Json& config);

 private:
  template <class Action>
  void write_netcdf(Action&& action);

  std::filesystem::path folder_;
  std::filesystem::path made_;  // topmost folder that was made; empty: none
  std::optional<Unfinished> unfinished_;
  std::unique_ptr<AtomicFile> config_, summary_, netcdf_file_;
  std::unique_ptr<results::RunWriter> netcdf_;
  std::vector<std::unique_ptr<AtomicFile>> filters_;
  std::string line_;
};

/// Nanoseconds as seconds with nine decimals, by integers only.
std::string seconds_text(Time t);

}  // namespace binnacle::command
