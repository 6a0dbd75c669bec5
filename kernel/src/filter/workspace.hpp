// SPDX-License-Identifier: Apache-2.0
// Scratch that the parts of an estimator share: the blocks of Φ and Qd, derived values and their Jacobians.
#pragma once

#include <cstddef>
#include <vector>

#include "binnacle/measurement_model.hpp"
#include "filter/plan.hpp"

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
  const double* value(int index) const { return values_[static_cast<std::size_t>(index)]; }
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

}  // namespace binnacle::filter
