// SPDX-License-Identifier: Apache-2.0
// A parameter whose unit is that of a port's block throws at its bound, by an exception that is none of ComponentError.
// fails: robustness.parameters
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.parameters.push_back(
        binnacle::parameter::number("drift", "@p*s^-1").at_least(0).at_most(9).defaults("1").about("made up"));
    return spec;
  }
  explicit Subject(const binnacle::Binding& binding) : Measurement(binding) {
    if (!(binding.parameters().number("drift") > 0)) throw std::runtime_error("the drift is zero");
  }
};

}  // namespace

BINNACLE_PLUGIN("unit_of_a_port", "1.0.0", registry) { registry.add<Subject>(); }
