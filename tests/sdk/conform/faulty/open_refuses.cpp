// SPDX-License-Identifier: Apache-2.0
// Its port cannot be opened here, and it says so by a ComponentError, as it may: nothing of it is tried.
// fails: verdict
#include "faulty.hpp"

namespace faulty::open_refuses {

class Subject final : public Source {
 public:
  using Source::Source;
  void open(Reporter&) override { throw ComponentError("there is no port /dev/none"); }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("open_refuses")); }

}  // namespace faulty::open_refuses
