// SPDX-License-Identifier: Apache-2.0
// Does otherwise when its default is spelled out.
// fails: life.defaults
#include "animal.hpp"

namespace {

class Animal final : public zoo::Measurement {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.parameters.push_back(binnacle::parameter::vector("extra", "m", 1).defaults("[0.5]").about("another noise"));
    return spec;
  }
  explicit Animal(const binnacle::Binding& binding) : Measurement(binding) {
    static const double* first_seen = nullptr;
    if (!first_seen) first_seen = new double(0);
    sigma += binding.parameters().vector("extra")[0] * (constructed++ % 2);
  }

 private:
  static inline int constructed = 0;
};

}  // namespace

BINNACLE_PLUGIN("defaults_differ", "1.0.0", registry) { registry.add<Animal>(); }
