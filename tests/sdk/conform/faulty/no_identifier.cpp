// SPDX-License-Identifier: Apache-2.0
// Its type is no identifier.
// fails: load.register
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.type = "My Process";
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("no_identifier", "1.0.0", registry) { registry.add<Subject>(); }
