// SPDX-License-Identifier: Apache-2.0
// A parameter whose unit is that of a port's block throws at its bound, by an exception that is none of ComponentError.
// fails: robustness.parameters
#include "faulty.hpp"

namespace faulty::unit_of_a_port {

class Subject final : public Measurement {
 public:
  static ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.parameters.push_back(
        parameter::number("drift", "@p*s^-1").at_least(0).at_most(9).defaults("1").about("made up"));
    return spec;
  }
  explicit Subject(const Binding& binding) : Measurement(binding) {
    if (!(binding.parameters().number("drift") > 0)) throw std::runtime_error("the drift is zero");
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("unit_of_a_port")); }

}  // namespace faulty::unit_of_a_port
