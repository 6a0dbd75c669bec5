// SPDX-License-Identifier: Apache-2.0
// The covariance of what a measurement model reads, for models that ask for it.
#pragma once

#include <vector>

#include "binnacle/model_input.hpp"
#include "filter/covariance_form.hpp"
#include "filter/plan.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

/// C P Cᵀ with a row of C for each error component of each port that is read: of a state block a unit vector, or nothing
/// where the component is frozen; of a derived value its Jacobian, which must be in the workspace.
class ReadCovariance {
 public:
  explicit ReadCovariance(const FilterPlan& plan);

  /// Of all ports that `part` reads, until the next call. Null where its model does not ask for it.
  PortCovariance of(const PartPlan& part, const CovarianceForm& form, Workspace& workspace);

 private:
  void add(const PartPlan::Read& a, const PartPlan::Target& by_a, const PartPlan::Read& b, const PartPlan::Target& by_b,
           MatrixView P, Workspace& workspace);

  const FilterPlan& plan_;
  std::vector<double> covariance_;  // rows_ × rows_
  std::vector<int> first_row_;      // by port
  int rows_ = 0;                    // of the part at work
};

}  // namespace binnacle::filter
