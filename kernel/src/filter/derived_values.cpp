// SPDX-License-Identifier: Apache-2.0
#include "filter/derived_values.hpp"

#include <algorithm>

namespace binnacle::filter {

namespace {

const DerivedPlan& derived_of(const FilterPlan& plan, int value) {
  return plan.derived[as_size(value) - plan.blocks.size()];
}

bool is_block(const FilterPlan& plan, int value) { return value < static_cast<int>(plan.blocks.size()); }

int dof_of(const FilterPlan& plan, int value) {
  return is_block(plan, value) ? plan.blocks[as_size(value)].dof() : derived_of(plan, value).dof();
}

/// Adds J · chain of what is read to the Jacobian with respect to a state block.
void add_through(const DerivedPlan::Read& read, const DerivedPlan& inner, const DerivedPlan::Dependence& dependence,
                 int dof, int columns, Workspace& workspace) {
  const double* J = workspace.at(read.jacobian);
  double* total = workspace.at(dependence.jacobian);
  const int inner_dof = inner.dof();
  for (const auto& through : inner.dependences) {
    if (through.block != dependence.block) continue;
    const double* chain = workspace.at(through.jacobian);
    for (int c = 0; c < columns; ++c)
      for (int k = 0; k < inner_dof; ++k)
        for (int r = 0; r < dof; ++r) total[r + c * dof] += J[r + k * dof] * chain[k + c * inner_dof];
  }
}

void chain(const FilterPlan& plan, const DerivedPlan& derived, Workspace& workspace) {
  const int dof = derived.dof();
  for (const auto& dependence : derived.dependences)
    std::fill_n(workspace.at(dependence.jacobian), dof * plan.blocks[as_size(dependence.block)].dof(), 0.0);
  for (const auto& read : derived.reads)
    for (const auto& dependence : derived.dependences) {
      const int columns = plan.blocks[as_size(dependence.block)].dof();
      if (!is_block(plan, read.value)) {
        add_through(read, derived_of(plan, read.value), dependence, dof, columns, workspace);
      } else if (read.value == dependence.block) {
        const double* J = workspace.at(read.jacobian);
        double* total = workspace.at(dependence.jacobian);
        for (int i = 0; i < dof * columns; ++i) total[i] += J[i];
      }
    }
}

}  // namespace

Result evaluate_derived(const FilterPlan& plan, const std::vector<int>& values, const Moment& now, Workspace& workspace,
                        ModelCalls& calls) {
  for (const int index : values) {
    const auto& derived = derived_of(plan, index);
    const int dof = derived.dof();
    std::fill_n(workspace.jacobians.begin(), derived.ports.size(), MatrixView{});
    for (const auto& read : derived.reads) {
      const int columns = dof_of(plan, read.value);
      workspace.jacobians[as_size(read.port)] = MatrixView{workspace.at(read.jacobian), dof, columns, dof};
      std::fill_n(workspace.at(read.jacobian), dof * columns, 0.0);
    }
    DerivedOutput out{{workspace.at(derived.value), derived.derived->declaration().stored_size},
                      PortJacobians(workspace.jacobians.data())};
    const Result result =
        calls.evaluate(derived, workspace.values_of(derived.ports), workspace.driving(now, derived.driving_rates), out);
    if (!result) return result;
    chain(plan, derived, workspace);
  }
  return Result::ok();
}

}  // namespace binnacle::filter
