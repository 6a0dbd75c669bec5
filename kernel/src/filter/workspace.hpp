// SPDX-License-Identifier: Apache-2.0
// Scratch that the parts of an estimator share: the blocks of Φ and Qd, derived values and their Jacobians, and the rows
// of the sample at work.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "binnacle/measurement_model.hpp"
#include "filter/model_calls.hpp"

namespace binnacle::filter {

/// When models are called, and the mean rates of the last driving interval in the input channel's order (null: unknown).
struct Moment {
  Time t = no_time;
  const double* driving_rates = nullptr;
  bool bridged = false;  // that interval bridged a hole
};

class Workspace {
 public:
  /// x: the stored state.
  Workspace(const FilterPlan& plan, double* x);

  double* at(std::size_t offset) { return doubles_.data() + offset; }
  /// Where a state block's or a derived value lies.
  const double* value(int index) const { return values_[as_size(index)]; }
  /// The ports of a model: null where one is open.
  const double* const* values_of(const std::vector<int>& ports);
  /// What a component that reads these driving rates may know.
  Driving driving(const Moment& now, const std::vector<int>& driving_rates);

  std::vector<double*> phi, noise;    // tables of blocks
  std::vector<MatrixView> jacobians;  // per port of the component being called

 private:
  std::vector<double> doubles_;
  std::vector<const double*> values_;
  std::vector<const double*> port_values_;
  std::vector<double> driving_rates_;
};

/// Derived blocks: evaluates the values, given in order of dependence, into the workspace, with their Jacobians chained to
/// the state blocks; ends with the first refusal.
Result evaluate_derived(const FilterPlan& plan, const std::vector<int>& values, const Moment& now, Workspace& workspace,
                        ModelCalls& calls);

/// The rows of the sample at work: linearize() fills them, judge() may thin them out, correct() applies them.
struct SampleRows {
  explicit SampleRows(const FilterPlan& plan);
  SampleRows(const SampleRows&) = delete;
  SampleRows& operator=(const SampleRows&) = delete;

  /// No rows of this measurement yet.
  void begin(const MeasurementPlan& measurement);
  MatrixView square(double* matrix) const { return {matrix, m, m, work.m_max}; }

  int m = 0;        // rows
  UpdateWork work;  // over the memory below; work.R is what the noise estimator makes of R_nominal
  double nis = 0;
  int left_out = 0;  // rows that a gate by row or key took out, and their keys and groups
  std::vector<double> R_nominal, delta;
  std::vector<std::int64_t> keys, left_out_keys;
  std::vector<int> groups, left_out_groups;

 private:
  std::vector<double> H_, R_, r_, G_, HPHt_, S_, L_, K_, U_, y_;
};

}  // namespace binnacle::filter
