// SPDX-License-Identifier: Apache-2.0
// CsvRecords: what one filter estimates, as a table in text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "atomic_file.hpp"
#include "number_text.hpp"
#include "results/row_block.hpp"
#include "score/run.hpp"

namespace binnacle::command {

/// Of a recorded column, by its unit and what it is: sdk/docs/results.md says which.
Digits digits_of(const score::RecordColumn& column);

/// One header row, "t[s],position.lat[rad],…,position.lat.sigma[rad],…", then the rows: SI, times in seconds to the nanosecond.
class CsvRecords {
 public:
  /// Throws UsageError where the file cannot be made.
  CsvRecords(std::filesystem::path path, const std::vector<score::RecordColumn>& columns);
  /// Throws OutputError, as commit() does.
  void write(const results::RowBlock& rows);
  void complete() { file_.complete(); }
  void commit() { file_.commit(); }

 private:
  AtomicFile file_;
  std::vector<Digits> digits_;
  std::string text_;  // of some rows
};

/// FILTER.csv: a filter's name is any JSON key; what a file name cannot have, or hides, becomes %2F and the like.
std::string csv_name(const std::string& filter);

}  // namespace binnacle::command
