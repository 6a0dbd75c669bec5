// SPDX-License-Identifier: Apache-2.0
// Its type is no identifier.
// fails: load.register
#include "../faulty.hpp"

namespace faulty::no_identifier {

class Subject final : public Process {
 public:
  using Process::Process;
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.type = "My Process";
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(); }

}  // namespace faulty::no_identifier
