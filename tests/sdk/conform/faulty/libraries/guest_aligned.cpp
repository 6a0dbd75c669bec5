// SPDX-License-Identifier: Apache-2.0
// Another Eigen alignment: accepted, for no owning Eigen object crosses, with a warning. Beside the healthy types, one has
// parameters that exclude each other, which is allowed: the warning is not taken for the refusal.
// fails: load.guard warn
#include "../faulty.hpp"

namespace {

using namespace faulty;

class Refusing final : public Measurement {
 public:
  static ComponentSpec spec() {
    auto spec = named<Measurement>("refusing");
    spec.parameters.push_back(
        parameter::number("cut", "m").above(0).at_most(20).defaults("15").about("beyond which nothing counts"));
    return spec;
  }
  explicit Refusing(const Binding& binding) : Measurement(binding) {
    if (binding.parameters().number("cut") < 2 * sigma) throw ComponentError("'cut' is below two sigmas");
  }
};

}  // namespace

BINNACLE_PLUGIN("guest_aligned", "1.0.0", registry) {
  register_all(registry);
  registry.add<Refusing>();
}
