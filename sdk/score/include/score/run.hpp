// SPDX-License-Identifier: Apache-2.0
// run: a composition with its sources, recorded and scored against its references.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/run_together.hpp"
#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"
#include "binnacle/trust.hpp"
#include "score/metric.hpp"
#include "score/sections.hpp"

namespace binnacle::score {

/// One column of a record: "position.lat" in "rad".
struct RecordColumn {
  std::string name;
  std::string unit;
};

/// One error over a run, truth − estimate, at the times of the reference; spans end with the call that gave them.
struct ErrorSeries {
  std::string name;  // "position.horizontal", "position.nees"; "match.velocity.noise": an adapted √R
  std::string unit;  // SI, as the numbers are
  std::string display_unit;
  std::span<const Time> t;
  std::span<const double> values;
  std::span<const double> sigma;  // what the filter thought of it, 1-σ; empty where that is not known
};

/// Watches a run while it happens.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// Before the first sample and before step_observer(). The session may be read in all calls up to finished().
  virtual void begin_run(const Session& /*session*/) {}
  /// After each instant, once what is recorded of it was given.
  virtual void after_instant() {}
  /// After the last instant.
  virtual void finished() {}
  /// Whether begin() and record() are wanted; reading estimates and their 1-σ costs more than a filter step.
  virtual bool wants_records() const { return true; }
  /// Before the first record of each filter: what its rows hold, outputs and then their 1-σ.
  virtual void begin(int /*filter*/, const std::string& /*name*/, const std::vector<RecordColumn>& /*columns*/) {}
  /// Estimates at t, as often as the config's `record` says: of every multiple of its `every` after the first record
  /// the instant that is nearest, among the first behind it and those before it by at most a tenth of `every`.
  virtual void record(int /*filter*/, Time /*t*/, std::span<const double> /*values*/) {}
  /// A filter's own step observer, asked for before the run; null: none.
  virtual StepObserver* step_observer(int /*filter*/) { return nullptr; }
  /// As binnacle::RunObserver::noted().
  virtual void noted(const Diagnostic& /*note*/) {}
  /// After the run, if records are wanted: every error there is against references and withheld samples.
  virtual void scored(int /*filter*/, const ErrorSeries& /*errors*/) {}
  /// As binnacle::RunObserver has them.
  virtual bool wants_arrivals() const { return false; }
  virtual void arrived(const Arrival& /*arrival*/) {}
  /// Every now and then: the run's time. Return false to stop the run (it ends as if the data had).
  virtual bool progress(Time /*t*/) { return true; }
  /// As binnacle::RunObserver::exchange(), read back after every begin().
  virtual void exchange(StateBytes& /*bytes*/) {}
};

struct RunOptions {
  std::uint64_t seed = 1;
  int run = 0;  // which of a study's runs: random streams are keyed by (seed, run, component)
  RunObserver* observer = nullptr;
  std::vector<Metric> metrics = {};  // of this composition, for RunResult::metrics
  bool feeds_sinks = true;           // false where several runs share the composition's sinks
  bool wants_summary = true;         // false: metrics, warnings, failures and verdict are all; no summary, no doubts
  double pace = 0;                   // as binnacle::RunOptions has them
  RecordedInput* input = nullptr;
  Checkpoints checkpoints = {};
};

struct RunResult {
  /// { "filters": { NAME: { "reference", "windows", "withheld", "consistency", "unscored", "notes", "measurements",
  ///   "start_s", "waited", "end_s", "steps", "filter_s", "verdict" } }, "metrics", "windows", "live", "warnings", "wall_s" }; figures
  ///   carry their unit.
  nlohmann::ordered_json summary;
  std::vector<MetricValue> metrics;  // those of RunOptions, in their order
  Diagnostics warnings;              // gaps and repairs in the data
  Diagnostics failures;              // B080 broken, B081 never started; empty when all went well
  Verdict verdict = Verdict::ok;     // the worst of all filters'
  Diagnostics doubts;                // why it is not ok, and likely causes: B100 to B120
};

/// What became of a filter's samples so far: { "measurements", "start_s", "end_s", "steps", "input_gaps", "filter_s", "verdict",
/// "broken" }.
nlohmann::ordered_json run_figures(const Session& session, FilterId filter);

/// Its filters, and those that come of smoothing: what a RunObserver's `filter` counts.
const std::vector<FilterInfo>& filters_of(const Composition& composition);

/// As binnacle::run(), of a composition loaded with sections(), whose references and metrics are scored.
RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options = {});

/// Whether run_together() takes it: recorded or simulated sources, and no smoothing that goes back over them.
bool can_run_together(const Composition& composition);

struct RunRequest {
  std::shared_ptr<const Composition> composition;
  RunOptions options = {};
};

/// What run() returns, or what it throws.
struct RunOutcome {
  RunResult result;
  std::exception_ptr thrown = nullptr;
};

/// As binnacle::run_together(): what run() gives of each, over samples that are made once.
std::vector<RunOutcome> run_together(const std::vector<RunRequest>& requests);

}  // namespace binnacle::score
