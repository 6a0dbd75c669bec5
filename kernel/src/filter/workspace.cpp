// SPDX-License-Identifier: Apache-2.0
#include "filter/workspace.hpp"

#include <algorithm>

namespace binnacle::filter {

Workspace::Workspace(const FilterPlan& plan, double* x) : doubles_(plan.workspace) {
  for (const auto one : plan.ones) doubles_[one] = 1.0;
  for (const auto& block : plan.blocks) values_.push_back(x + block.stored_offset);
  for (const auto& derived : plan.derived) values_.push_back(doubles_.data() + derived.value);
  for (const auto offset : plan.transition_blocks) phi.push_back(doubles_.data() + offset);
  for (const auto offset : plan.noise_blocks) noise.push_back(doubles_.data() + offset);
  std::size_t ports = 1, rates = 1;
  for (const auto& process : plan.processes) ports = std::max(ports, process.ports.size());
  const auto widen = [&](const auto& component) {
    ports = std::max(ports, component.ports.size());
    rates = std::max(rates, component.driving_rates.size());
  };
  for (const auto& derived : plan.derived) widen(derived);
  for (const auto& measurement : plan.measurements)
    for (const auto& part : measurement.parts) widen(part);
  port_values_.resize(ports);
  jacobians.resize(ports);
  driving_rates_.resize(rates);
}

const double* const* Workspace::values_of(const std::vector<int>& ports) {
  for (std::size_t p = 0; p < ports.size(); ++p) port_values_[p] = ports[p] < 0 ? nullptr : value(ports[p]);
  return port_values_.data();
}

Driving Workspace::driving(const Moment& now, const std::vector<int>& driving_rates) {
  Driving u;
  u.t = now.t;
  u.bridges = now.bridged;
  if (!driving_rates.empty() && now.driving_rates) {
    for (std::size_t i = 0; i < driving_rates.size(); ++i)
      driving_rates_[i] = now.driving_rates[as_size(driving_rates[i])];
    u.rates = driving_rates_.data();
  }
  return u;
}

namespace {

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
      if (!plan.is_block(read.value)) {
        add_through(read, plan.derived_at(read.value), dependence, dof, columns, workspace);
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
    const auto& derived = plan.derived_at(index);
    const int dof = derived.dof();
    std::fill_n(workspace.jacobians.begin(), derived.ports.size(), MatrixView{});
    for (const auto& read : derived.reads) {
      const int columns = plan.dof(read.value);
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

SampleRows::SampleRows(const FilterPlan& plan) {
  const auto ld = as_size(padded(plan.n));
  const auto rows = as_size(plan.max_rows), columns = as_size(plan.max_columns);
  H_.assign(rows * columns, 0.0);
  for (auto* square : {&R_, &HPHt_, &S_, &L_, &R_nominal}) square->assign(rows * rows, 0.0);
  for (auto* column : {&r_, &y_}) column->assign(rows, 0.0);
  for (auto* tall : {&G_, &K_, &U_}) tall->assign(ld * std::max<std::size_t>(rows, 3), 0.0);
  delta.assign(ld, 0.0);
  for (auto* list : {&keys, &left_out_keys}) list->assign(rows, 0);
  for (auto* list : {&groups, &left_out_groups}) list->assign(rows, 0);
  work = UpdateWork{plan.max_rows, H_.data(), R_.data(), r_.data(), G_.data(), HPHt_.data(),
                    S_.data(),     L_.data(), K_.data(), U_.data(), y_.data()};
}

void SampleRows::begin(const MeasurementPlan& measurement) {
  work.m_max = measurement.max_rows;
  m = 0;
  left_out = 0;
  nis = 0;
  std::fill_n(work.H, as_size(work.m_max) * measurement.columns.size(), 0.0);
  std::fill_n(R_nominal.data(), work.m_max * work.m_max, 0.0);
}

}  // namespace binnacle::filter
