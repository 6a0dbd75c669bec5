// SPDX-License-Identifier: Apache-2.0
// RecordedRun: the page of a run, from what is seen of it while it goes on.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "report/page.hpp"
#include "results/row_block.hpp"
#include "score/run.hpp"

namespace binnacle::report {

/// Memory does not grow with the rows, nor with the samples of measurements. Where all of a series may be drawn, the page is that
/// of page(); of longer ones it draws the least and the greatest of stretches that are at most twice as long as there.
class RecordedRun {
 public:
  /// The composition must outlive it.
  explicit RecordedRun(const Composition& composition, const Limits& limits = {});
  ~RecordedRun();
  RecordedRun(const RecordedRun&) = delete;
  RecordedRun& operator=(const RecordedRun&) = delete;

  /// By any one thread.
  void take(int filter, const results::ColumnBlock& rows);
  /// What became of samples, by the run's thread.
  StepObserver* step_observer(int filter);
  void scored(int filter, const score::ErrorSeries& errors);

  /// When all of it has come.
  std::string page(const results::Json& summary, const results::Json& config, const results::Json& provenance,
                   std::optional<results::StudyResults> study);

 private:
  class Filter;
  Limits limits_;
  std::vector<std::unique_ptr<Filter>> filters_;
};

}  // namespace binnacle::report
