// SPDX-License-Identifier: Apache-2.0
// A unit that there is not.
// fails: load.register
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].unit = "furlong^2/s^3";
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("odd_unit", "1.0.0", registry) { registry.add<Subject>(); }
