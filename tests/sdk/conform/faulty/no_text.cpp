// SPDX-License-Identifier: Apache-2.0
// A parameter without a line of text.
// fails: metadata.text
#include "faulty.hpp"

namespace faulty::no_text {

class Subject final : public Process {
 public:
  using Process::Process;
  static ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].text.clear();
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("no_text")); }

}  // namespace faulty::no_text
