// SPDX-License-Identifier: Apache-2.0
// RunWriter: a run as a NetCDF-4 file, written while it happens.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/composition.hpp"
#include "results/results.hpp"
#include "score/run.hpp"

namespace binnacle::results {

/// The block whose error component an error is and which, where all of them share a unit and are columns of one variable; else
/// null and −1.
std::pair<const BlockInfo*, int> component_of(const FilterInfo& filter, const score::ErrorSeries& errors);

/// Takes what a RunObserver gets. Holds no more than a chunk of each variable in memory. Throws WriteError from any
/// of its calls but those of the step observer, whose failure the next call reports.
class RunWriter {
 public:
  /// Replaces what is at `path`. `provenance`: as RunResults::provenance.
  RunWriter(const std::filesystem::path& path, const Composition& composition, const Json& provenance);
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns);
  void record(int filter, Time t, std::span<const double> values);
  StepObserver* step_observer(int filter);
  void scored(int filter, const score::ErrorSeries& errors);
  /// The file is whole only after this.
  void close();

 private:
  class Filter;
  struct Contents;
  std::unique_ptr<Contents> contents_;
};

}  // namespace binnacle::results
