// SPDX-License-Identifier: Apache-2.0
// Another Eigen alignment, which is a warning, and parameters that exclude each other, which is allowed: the warning is not
// taken for the refusal.
// fails: load.guard warn
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.parameters.push_back(binnacle::parameter::number("cut", "m")
                                  .above(0)
                                  .at_most(20)
                                  .defaults("15")
                                  .about("beyond which nothing counts"));
    return spec;
  }
  explicit Subject(const binnacle::Binding& binding) : Measurement(binding) {
    if (binding.parameters().number("cut") < 2 * sigma) throw binnacle::ComponentError("'cut' is below two sigmas");
  }
};

}  // namespace

BINNACLE_PLUGIN("guest_refuses", "1.0.0", registry) { registry.add<Subject>(); }
