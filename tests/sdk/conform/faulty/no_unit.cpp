// SPDX-License-Identifier: Apache-2.0
// A number without unit.
// fails: metadata.units
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].unit = "";
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("no_unit", "1.0.0", registry) { registry.add<Subject>(); }
