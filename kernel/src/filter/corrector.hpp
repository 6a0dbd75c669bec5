// SPDX-License-Identifier: Apache-2.0
// A correction, whole or not at all: every plugin call comes before x and P change.
#pragma once

#include <vector>

#include "filter/covariance_form.hpp"
#include "filter/model_calls.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

class Corrector {
 public:
  Corrector(const FilterPlan& plan, ModelCalls& calls);

  /// δ = K r, x ← x ⊞ δ, P by the form and then by the blocks' reset Jacobians.
  void run(const MeasurementPlan& measurement, double* x, CovarianceForm& P, SampleRows& rows);
  /// What a noise estimator wants to see afterwards: r − H δ, and work.HPHt = H P⁺ Hᵀ (before the reset), of the rows that
  /// run() was given. Only where the measurement's estimator wants_after().
  const double* post_fit() const { return post_fit_.data(); }
  /// Whether the last run() transformed P, and by what: n×n.
  bool has_reset() const { return !resets_.empty(); }
  void expand_reset(MatrixView T) const;

 private:
  /// A block with components in P.
  struct Part {
    const BlockPlan* block = nullptr;
    int dof = 0;
    bool is_whole = false;  // its δ is a piece of the filter's
  };
  struct Reset {
    int first = 0;
    int dof = 0;
    std::size_t jacobian = 0;  // offset in jacobians_: dof×dof, of the active components
  };
  void inject(const double* x, const double* delta);
  void find_reset(const BlockPlan& block);

  const FilterPlan& plan_;
  ModelCalls& calls_;
  std::vector<Part> parts_;
  std::vector<double> x_plus_;
  std::vector<double> block_delta_;
  std::vector<double> jacobian_;  // of a whole block
  std::vector<double> jacobians_;
  std::vector<Reset> resets_;
  std::vector<double> post_fit_;
};

}  // namespace binnacle::filter
