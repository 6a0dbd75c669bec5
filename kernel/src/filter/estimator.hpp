// SPDX-License-Identifier: Apache-2.0
// What a filter estimates: the stored state, the covariance of its errors, and the memories of its models.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "filter/corrector.hpp"
#include "filter/covariance_form.hpp"
#include "filter/fields.hpp"
#include "filter/judge.hpp"
#include "filter/linearizer.hpp"
#include "filter/model_calls.hpp"
#include "filter/propagator.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

class Estimator {
 public:
  /// Allocates here and nothing afterwards. All of it may throw Stop, or what a plugin throws.
  Estimator(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena, ModelCalls& calls);

  /// Before the start: x and P zero, memories as their models begin with them.
  void reset();
  /// x and P from the config or from the latest samples of the initial channels.
  void start();

  /// A step in three: what the models make of it; P; x.
  void propagate(const Moment& now, Time t1, std::span<const InputSample> samples) {
    propagator_.run(now, t1, samples, x());
  }
  void predict() { P_->predict(workspace_.phi.data(), workspace_.noise.data()); }
  void advance() { std::copy_n(x_plus(), plan_.stored_size, x()); }
  const double* x_plus() const { return propagator_.x_plus(); }
  const Workspace& workspace() const { return workspace_; }

  /// A sample in three. linearize() keeps the models' memories; roll_back() restores them.
  Result linearize(const MeasurementPlan& measurement, const SampleView& sample, const Moment& now);
  Judgement judge(const MeasurementPlan& measurement, Time t, double dt, bool is_withheld) {
    return judge_.run(measurement, t, dt, is_withheld, *P_, rows_);
  }
  void correct(const MeasurementPlan& measurement) { corrector_.run(measurement, x(), *P_, rows_); }
  void roll_back(const MeasurementPlan& measurement);
  /// After a correction: the noise estimator sees what is left.
  void learn(const MeasurementPlan& measurement);
  const SampleRows& rows() const { return rows_; }
  const Corrector& corrector() const { return corrector_; }

  /// Adds a measurement's named variances to P.
  void inflate(const MeasurementPlan& measurement);

  /// Stops a filter whose state is not finite or whose variances are negative or beyond all bounds.
  void check_step(Time t) const {
    if (!is_sound()) stop_unsound(t, propagator_.culprit(t));
  }
  void check_update(Time t) const {
    if (!is_sound()) stop_unsound(t, "");
  }

  const double* state() const { return plan_.state.in(arena_); }
  const CovarianceForm& covariance() const { return *P_; }
  /// The estimates as a sample: outputs of all blocks, P in their error dof.
  void write(SampleWriter& slot);

 private:
  double* x() { return plan_.state.in(arena_); }
  void start_value(const BlockPlan& block);
  void start_covariance(const BlockPlan& block, MatrixView P);
  SampleView initial_sample(const BlockPlan& block) const;
  bool is_sound() const;
  [[noreturn]] void stop_unsound(Time t, const std::string& culprit) const;

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  std::byte* arena_;
  ModelCalls& calls_;
  std::unique_ptr<CovarianceForm> P_;
  Workspace workspace_;
  AuxiliaryReader auxiliary_;
  Propagator propagator_;
  Linearizer linearizer_;
  Judge judge_;
  Corrector corrector_;
  SampleRows rows_;
  std::vector<std::byte> memory_backup_;  // of a measurement's models
  std::vector<double> initial_P_, initial_outputs_;
};

}  // namespace binnacle::filter
