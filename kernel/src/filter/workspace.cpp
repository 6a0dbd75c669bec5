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

}  // namespace binnacle::filter
