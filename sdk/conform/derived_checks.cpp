// SPDX-License-Identifier: Apache-2.0
// numbers.derived: its Jacobians against differences, its value with and without them.
#include "compare.hpp"

namespace binnacle::conform {

namespace {

void jacobian(Trial& trial) {
  const auto composition = compose_example(trial);
  const DerivedFixture derived(trial, *composition);
  const auto& reads = derived.part.model->declaration().read_ports;
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(600 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = derived.ports(random, 0.3);
    const auto nominal = derived.call(ports, unwritten());
    if (!nominal.answer.result) Trial::skip(std::string("it refuses ordinary values: ") + nominal.answer.result.reason);
    for (std::size_t port = 0; port < ports.size(); ++port) {
      if (ports[port].is_open()) continue;
      const auto found = std::find(reads.begin(), reads.end(), static_cast<int>(port));
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(derived.yields->declaration().dof(), ports[port].dof());
      if (found != reads.end()) J = nominal.J[static_cast<std::size_t>(found - reads.begin())];
      const auto change = [&](const PortStates& at) -> Eigen::VectorXd {
        const auto evaluated = derived.call(at, unwritten());
        Eigen::VectorXd delta = Eigen::VectorXd::Constant(derived.yields->declaration().dof(), NAN);
        if (evaluated.answer.result) derived.yields->minus(evaluated.value.data(), nominal.value.data(), delta.data());
        return delta;
      };
      const double largest = J.cwiseAbs().maxCoeff();
      const auto& errors = derived.yields->declaration().error;
      const Mismatch m = compare_over_steps(ports, port, J, change, [&](Eigen::Index i, Eigen::Index j) {
        return 1e-3 * largest + 1e-6 * scale_of(errors[static_cast<std::size_t>(i)].unit) / ports[port].scale[j];
      });
      if (!trial.expect(!m.is_there, "J of '", derived.part.type->spec.ports[port].name, "' (", m.row, ",", m.column,
                        "): ",
                        found == reads.end() ? "the port is not declared as read"
                                             : "declared " + std::to_string(m.declared),
                        ", differences of the value give ", m.numeric))
        return;
    }
  }
}

void value(Trial& trial) {
  const auto composition = compose_example(trial);
  const DerivedFixture derived(trial, *composition);
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    auto random = trial.random(700 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = derived.ports(random, 0.3);
    if (!trial.expect(derived.call(ports, unwritten()).value == derived.call(ports, unwritten(), false).value,
                      "the value is another one when no Jacobian is wanted"))
      return;
  }
}

}  // namespace

std::vector<Check> derived_checks() {
  const std::vector<Role> roles = {Role::derived_block};
  return {
      {"numbers.derived.value",
       2,
       roles,
       {"life.repeatable"},
       "the value is the same to the bit with and without Jacobians",
       value},
      {"numbers.derived.jacobian",
       2,
       roles,
       {"numbers.derived.value"},
       "J is the derivative of the value on the manifolds, and what is not read has none",
       jacobian},
  };
}

}  // namespace binnacle::conform
