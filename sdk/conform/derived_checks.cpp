// SPDX-License-Identifier: Apache-2.0
// numbers.derived: its Jacobians against differences, its value with and without them.
#include "fixture.hpp"

namespace binnacle::conform {

namespace {

void derived_jacobian(Trial& trial) {
  const auto composition = compose_example(trial);
  const DerivedFixture derived(trial, *composition);
  const auto& errors = derived.yields->declaration().error;
  Eigen::VectorXd scale(static_cast<Eigen::Index>(errors.size()));
  for (std::size_t i = 0; i < errors.size(); ++i) scale[static_cast<Eigen::Index>(i)] = scale_of(errors[i].unit);
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(600 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = derived.ports(random, 0.3);
    const auto nominal = derived.caller.evaluate(ports, derived.u());
    if (!nominal.result) Trial::skip(std::string("it refuses ordinary values: ") + nominal.result.reason);
    if (!trial.expect_none(testing::check_derived(derived.caller, *derived.yields, scale, ports, derived.u(),
                                                  {1e-3, 1e-6, testing::step_sweep})))
      return;
  }
}

void derived_value(Trial& trial) {
  const auto composition = compose_example(trial);
  const DerivedFixture derived(trial, *composition);
  for (int repeat = 0; repeat < trial.repeats(5); ++repeat) {
    auto random = trial.random(700 + static_cast<std::uint64_t>(repeat));
    if (!trial.expect_none(testing::check_derived_value(derived.caller, derived.ports(random, 0.3), derived.u())))
      return;
  }
}

}  // namespace

std::vector<Check> derived_checks() {
  const std::vector<Role> roles = {Role::derived_block};
  return {
      check("numbers.derived.value", 2, roles, {"life.repeatable"},
            "the value is the same to the bit with and without Jacobians", derived_value),
      check("numbers.derived.jacobian", 2, roles, {"numbers.derived.value"},
            "J is the derivative of the value on the manifolds, and what is not read has none", derived_jacobian),
  };
}

}  // namespace binnacle::conform
