// SPDX-License-Identifier: Apache-2.0
// A number without unit.
// fails: metadata.units
#include "faulty.hpp"

namespace faulty::no_unit {

class Subject final : public Process {
 public:
  using Process::Process;
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].unit = "";
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("no_unit")); }

}  // namespace faulty::no_unit
