// SPDX-License-Identifier: Apache-2.0
// A parameter without a line of text.
// fails: metadata.text
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].text.clear();
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("no_text", "1.0.0", registry) { registry.add<Subject>(); }
