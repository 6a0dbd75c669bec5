// SPDX-License-Identifier: Apache-2.0
// A block that does not move.
#include "random_constant.hpp"

namespace binnacle::core {

ComponentSpec RandomConstant::spec() {
  ComponentSpec spec;
  spec.type = "random_constant";
  spec.summary = "A block of any kind that is unknown but constant.";
  spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 3.8";
  spec.ports = {advances("x", "*").about("the constant block")};
  spec.example = R"json({"blocks": {"x": "mounting"}})json";
  spec.surroundings =
      R"json({"blocks": {"mounting": {"type": "vector", "size": 3, "unit": "rad", "sigma": 0.01}}})json";
  return spec;
}

RandomConstant::RandomConstant(const Binding& binding) : x_(binding.port("x")) {
  declaration_.at_rest();
  // F = 0 takes part in a joint discretization (a constant rate that something integrates), but only as a vector:
  // the continuous form wants stored value and error to be the same.
  if (binding.block("x").kind.starts_with("vector:")) declaration_.has_both_forms();
}

Result RandomConstant::propagate(const ProcessInput& in, ProcessOutput& out) const {
  out.x[x_].as() = in.x[x_].as();
  return Result::ok();
}

}  // namespace binnacle::core
