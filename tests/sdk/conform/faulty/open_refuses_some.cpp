// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: where it is to give more samples than it has, open() says so by a ComponentError.
// fails: nothing
#include "faulty.hpp"

namespace faulty::open_refuses_some {

class Subject final : public Source {
 public:
  using Source::Source;
  void open(Reporter&) override {
    if (samples < 20) throw ComponentError("a file of less than 20 samples is none");
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("open_refuses_some")); }

}  // namespace faulty::open_refuses_some
