// SPDX-License-Identifier: Apache-2.0
// Its example has a key that it does not take.
// fails: metadata.example
#include "faulty.hpp"

namespace faulty::broken_example {

class Subject final : public Process {
 public:
  using Process::Process;
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.example = R"({"blocks": {"p": "position", "v": "velocity"}, "tau": 3})";
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("broken_example")); }

}  // namespace faulty::broken_example
