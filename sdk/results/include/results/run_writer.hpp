// SPDX-License-Identifier: Apache-2.0
// RunWriter: a run as a NetCDF-4 file, written while it happens.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/composition.hpp"
#include "results/results.hpp"
#include "results/row_block.hpp"
#include "results/writer_thread.hpp"
#include "score/run.hpp"

namespace binnacle::results {

/// The block whose error component an error is and which, where all of them share a unit and are columns of one variable; else
/// null and −1.
std::pair<const BlockInfo*, int> component_of(const FilterInfo& filter, const score::ErrorSeries& errors);

/// Whether errors of this name are lengths, never negative.
bool is_norm(const FilterInfo& filter, const std::string& series);

/// Takes what a RunObserver gets, and writes it on a thread of its own that others share. Holds no more than a chunk of each
/// variable in memory. Throws WriteError, from calls of its own and out of the thread.
class RunWriter {
 public:
  /// Replaces what is at `path`. `provenance`: as RunResults::provenance. `level`: of compression, 1 to 9; 0 for none. The
  /// thread must outlive it; no task of this writer may wait there when it ends.
  RunWriter(const std::filesystem::path& path, const Composition& composition, const Json& provenance, int level,
            WriterThread& thread);
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  void begin(int filter, const std::vector<score::RecordColumn>& columns);
  /// On the thread: rows_of_block() of them, fewer only the last time.
  void write(int filter, const ColumnBlock& rows);
  StepObserver* step_observer(int filter);
  void scored(int filter, const score::ErrorSeries& errors);
  /// The file is whole only after this.
  void close();

 private:
  class Filter;
  struct Contents;
  WriterThread& thread_;
  std::unique_ptr<Contents> contents_;
};

}  // namespace binnacle::results
