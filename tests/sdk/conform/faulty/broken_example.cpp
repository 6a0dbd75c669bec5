// SPDX-License-Identifier: Apache-2.0
// Its example has a key that it does not take.
// fails: metadata.example
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.example = R"({"blocks": {"p": "position", "v": "velocity"}, "tau": 3})";
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("broken_example", "1.0.0", registry) { registry.add<Subject>(); }
