// SPDX-License-Identifier: Apache-2.0
// A unit that there is not.
// fails: load.register
#include "../faulty.hpp"

namespace faulty::odd_unit {

class Subject final : public Process {
 public:
  using Process::Process;
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].unit = "furlong^2/s^3";
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(); }

}  // namespace faulty::odd_unit
