// SPDX-License-Identifier: Apache-2.0
// CsvRecorder: what a run estimates, as one CSV file per filter in a folder.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "atomic_file.hpp"
#include "binnacle/run.hpp"
#include "output.hpp"

namespace binnacle::command {

/// FOLDER/FILTER.csv: one header row, "t[s],position.lat[rad],…,position.lat.sigma[rad],…"; SI numbers that read back
/// exactly; times in seconds to the nanosecond. Nothing is seen of the files before commit().
class CsvRecorder {
 public:
  /// Makes the folder. Throws UsageError when nothing can be written there.
  explicit CsvRecorder(std::filesystem::path folder);
  /// Leaves nothing behind that was not committed, the folder included if it was made here.
  ~CsvRecorder();
  CsvRecorder(const CsvRecorder&) = delete;
  CsvRecorder& operator=(const CsvRecorder&) = delete;

  void begin(int filter, const std::string& name, const std::vector<RecordColumn>& columns);
  void record(int filter, Time t, std::span<const double> values);
  /// Puts the records, config.json and at last summary.json in place: with summary.json there, all of it is.
  void commit(const Json& summary, const Json& config);

 private:
  std::filesystem::path folder_;
  std::filesystem::path made_;  // topmost folder that was made; empty: none
  std::unique_ptr<AtomicFile> config_, summary_;
  std::vector<std::unique_ptr<AtomicFile>> filters_;
  std::string line_;
};

/// Nanoseconds as seconds with nine decimals, by integers only.
std::string seconds_text(Time t);

}  // namespace binnacle::command
