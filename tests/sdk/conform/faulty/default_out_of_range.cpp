// SPDX-License-Identifier: Apache-2.0
// Its default lies outside its own range.
// fails: load.register
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  static binnacle::ComponentSpec spec() {
    auto spec = Process::spec();
    spec.parameters[0].default_json = "-1";
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("default_out_of_range", "1.0.0", registry) { registry.add<Subject>(); }
