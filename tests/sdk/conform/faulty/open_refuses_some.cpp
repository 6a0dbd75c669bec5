// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: where it is to give more samples than it has, open() says so by a ComponentError.
// fails: nothing
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  void open(binnacle::Reporter&) override {
    if (samples < 20) throw binnacle::ComponentError("a file of less than 20 samples is none");
  }
};

}  // namespace

BINNACLE_PLUGIN("open_refuses_some", "1.0.0", registry) { registry.add<Subject>(); }
