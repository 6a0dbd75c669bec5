// SPDX-License-Identifier: Apache-2.0
// A parameter whose unit is a product throws at its bound, by an exception that is none of ComponentError.
// fails: robustness.parameters
#include "faulty.hpp"

namespace faulty::unit_of_a_product {

class Subject final : public Measurement {
 public:
  static ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.parameters.push_back(
        parameter::number("blur", "m*s").at_least(0).at_most(9).defaults("\"1 m*s\"").about("made up"));
    return spec;
  }
  explicit Subject(const Binding& binding) : Measurement(binding) {
    if (!(binding.parameters().number("blur") > 0)) throw std::runtime_error("the blur is zero");
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("unit_of_a_product")); }

}  // namespace faulty::unit_of_a_product
