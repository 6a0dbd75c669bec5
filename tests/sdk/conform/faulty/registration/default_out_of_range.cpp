// SPDX-License-Identifier: Apache-2.0
// Its default lies outside its own range.
// fails: load.register
#include "../faulty.hpp"

namespace faulty::default_out_of_range {

class Subject final : public Process {
 public:
  using Process::Process;
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].default_json = "-1";
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(); }

}  // namespace faulty::default_out_of_range
