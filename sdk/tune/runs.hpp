// SPDX-License-Identifier: Apache-2.0
// The runs behind a likelihood: every config that is tuned over, at given values.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "log_recorder.hpp"
#include "response.hpp"
#include "study/workers.hpp"
#include "tune/plan.hpp"
#include "tune/tune.hpp"

namespace binnacle::tune {

using RunSettings = TuneOptions;
using study::in_parallel;

/// What is judged: as configured; without gates; or, without gates, only what the last run accepted.
enum class Gates { as_configured, off, frozen };

/// A run with an observer for each filter. Throws FilterError where one breaks, Interrupted.
void observed_run(const std::shared_ptr<const Composition>& composition, const std::vector<StepObserver*>& observers,
                  const RunSettings& settings);

/// Every filter of one config, recorded.
struct MemberRun {
  std::shared_ptr<const Composition> composition;
  std::vector<std::unique_ptr<RecordedRun>> filters;
};

/// Counts of what the likelihood is made of.
struct Counts {
  int samples = 0, rows = 0, refused = 0, rows_refused = 0, recoveries = 0;
  double nis = 0, likelihood = 0;
};

class Runs {
 public:
  /// Throws as score::load() does, and ConfigError (B130) where R of a measurement is adapted.
  Runs(const Plan& plan, RunSettings settings);

  /// By open-loop runs: Response.
  std::vector<Law> laws();
  /// Of a parameter of noise; known after laws().
  bool acts_on_R(std::size_t parameter) const { return parameter < acts_on_R_.size() && acts_on_R_[parameter]; }

  /// One run each, without slopes. Throws FilterError where a filter breaks or has no update.
  std::vector<MemberRun> record(const std::vector<double>& u, Gates gates);
  /// The slopes of every parameter with a law of noise, in their order: ∂/∂g.
  void add_slopes(std::vector<MemberRun>& runs, const std::vector<double>& u, const std::vector<Law>& laws,
                  Gates gates);
  /// What `frozen` accepts from now on.
  void freeze(const std::vector<MemberRun>& runs);

  Counts count(const std::vector<MemberRun>& runs) const;
  const Json& config(std::size_t member) const { return configs_[member]; }
  int made() const { return made_; }
  int missed() const { return missed_; }
  /// Measurements whose update is not the plain one, quoted.
  std::vector<std::string> not_ekf() const { return {not_ekf_.begin(), not_ekf_.end()}; }
  /// Filters that are propagated by sigma points, quoted.
  std::vector<std::string> unscented() const { return {unscented_.begin(), unscented_.end()}; }
  const RunSettings& settings() const { return settings_; }

 private:
  std::vector<std::string> gate_sets(std::size_t member, Gates gates) const;
  std::shared_ptr<const Composition> compose(std::size_t member, const std::vector<double>& u, Gates gates,
                                             const std::vector<std::string>& more = {}) const;
  std::vector<std::vector<SparseTerm>> slopes(std::size_t member, const MemberRun& run, double change,
                                              const std::vector<double>& u, Gates gates, int& missed) const;

  const Plan& plan_;
  RunSettings settings_;
  std::vector<Json> configs_;                     // by member, as resolved
  std::vector<std::vector<std::string>> frozen_;  // by member: what --set withholds
  std::vector<bool> acts_on_R_;
  int made_ = 0, missed_ = 0;
  std::set<std::string> not_ekf_, unscented_;
};

/// g of the law: what noise is affine in; and dg/du.
double law_value(Law law, double value);
double law_slope(Law law, const Parameter& parameter, double value);
inline bool is_of_noise(Law law) { return law == Law::square || law == Law::linear || law == Law::curved; }

}  // namespace binnacle::tune
