// SPDX-License-Identifier: Apache-2.0
// A block that does not move.
#include "random_constant.hpp"

#include <algorithm>

namespace binnacle::core {

ComponentSpec RandomConstant::spec() {
  ComponentSpec spec;
  spec.type = "random_constant";
  spec.summary = "A block of any kind that does not move: unknown, but constant.";
  spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 3.8";
  spec.ports = {advances("x", "*", "the constant block")};
  spec.example = R"json({"blocks": {"x": "mounting"}})json";
  spec.surroundings =
      R"json({"blocks": {"mounting": {"type": "vector", "size": 3, "unit": "rad", "sigma": 0.01}}})json";
  return spec;
}

RandomConstant::RandomConstant(const Binding& binding) : stored_size_(binding.block("x").stored_size) {
  // F = 0 takes part in a joint discretization (a constant rate that something integrates), but only as a vector:
  // the continuous form wants stored value and error to be the same.
  declaration_.has_continuous_form = binding.block("x").kind.starts_with("vector:");
  declaration_.is_time_invariant = declaration_.has_continuous_form;
}

Result RandomConstant::propagate(const Step& /*step*/, const double* const* x, std::byte* /*memory*/,
                                 const legacy::ProcessOutput& out) const {
  std::copy_n(x[0], stored_size_, out.x_plus[0]);
  return Result::ok();
}

}  // namespace binnacle::core
