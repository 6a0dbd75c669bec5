// SPDX-License-Identifier: Apache-2.0
// Derived blocks: J against differences of the value.
#include <algorithm>

#include "binnacle/view.hpp"
#include "differences.hpp"
#include "guarded.hpp"

namespace binnacle::testing {

Evaluated DerivedCaller::evaluate(const PortStates& ports, const Driving& u, bool with_jacobian, double fill) const {
  const DerivedDeclaration& declared = model_->declaration();
  Guarded value(as_size(declared.stored_size), fill);
  std::vector<Guarded> J;
  std::vector<MatrixView> views, by_port(ports.size());
  for (const int port : declared.read_ports)
    J.emplace_back(as_size(declared.dof()) * as_size(ports.at(as_size(port)).dof()), 0.0);
  for (std::size_t i = 0; i < J.size(); ++i) {
    const auto port = as_size(declared.read_ports[i]);
    views.push_back({J[i].data(), declared.dof(), ports[port].dof(), declared.dof()});
    by_port[port] = views.back();
  }
  Inputs inputs;
  const auto x = pointers(ports, spec_, inputs);
  const double* rates = inputs.keep("the driving rates", u.rates.data(), spec_->driving_rates.size());
  DerivedOutput output{{value.data(), declared.stored_size},
                       with_jacobian ? PortJacobians(by_port.data()) : PortJacobians()};
  Evaluated out;
  out.result = called("evaluate", [&] { return model_->evaluate({x.data(), {u.t, rates}}, output); });
  out.damage = inputs.damage("evaluate");
  if (!out.result) return out;
  examine(value, "value", fill, out.damage);
  for (const auto& block : J) examine(block, "J", 0.0, out.damage);
  out.value = value.values();
  append(out.numbers, out.value);
  for (const auto& view : views) {
    out.J.push_back(view.as());
    if (with_jacobian) append(out.numbers, {out.J.back().data(), out.J.back().data() + out.J.back().size()});
  }
  return out;
}

Complaints check_derived(const DerivedCaller& derived, const StateBlock& yields, const Eigen::VectorXd& scale,
                         const PortStates& ports, const Driving& u, const Tolerance& tolerance, double resolution) {
  Complaints out;
  const Evaluated nominal = derived.evaluate(ports, u);
  if (!nominal.damage.empty()) out.add(nominal.damage);
  if (!nominal.result) return out.add("refused: ", nominal.result.reason), out;
  const int dof = yields.declaration().dof();
  const Function change = [&](const PortStates& at) -> Eigen::VectorXd {
    const Evaluated evaluated = derived.evaluate(at, u);
    Eigen::VectorXd delta = Eigen::VectorXd::Constant(dof, NAN);
    if (evaluated.result) yields.minus(evaluated.value, nominal.value, delta);
    return delta;
  };
  const auto& reads = derived.model().declaration().read_ports;
  for (std::size_t port = 0; port < ports.size(); ++port) {
    if (ports[port].is_open()) continue;
    const auto found = std::find(reads.begin(), reads.end(), static_cast<int>(port));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dof, ports[port].dof());
    if (found != reads.end()) J = nominal.J[static_cast<std::size_t>(found - reads.begin())];
    const double largest = J.cwiseAbs().maxCoeff();
    compare({"J of '" + derived.spec().ports[port].name + "'", J,
             found == reads.end() ? "the port is not declared as read" : "",
             [&](Eigen::Index i, Eigen::Index j) {
               return tolerance.relative * largest + tolerance.neglected * scale[i] / ports[port].scale[j];
             },
             resolution},
            ports, port, change, tolerance.steps, out);
  }
  return out;
}

Complaints check_derived_value(const DerivedCaller& derived, const PortStates& ports, const Driving& u) {
  Complaints out;
  const Evaluated with = derived.evaluate(ports, u, true), without = derived.evaluate(ports, u, false);
  if (!without.damage.empty()) out.add("without Jacobians: ", without.damage);
  if (with.result.refusal != without.result.refusal) out.add("without Jacobians it refuses otherwise");
  if (with.value.size() != without.value.size() ||
      !std::equal(with.value.begin(), with.value.end(), without.value.begin(), same_bits))
    out.add("the value differs when no Jacobian is requested");
  return out;
}

}  // namespace binnacle::testing
