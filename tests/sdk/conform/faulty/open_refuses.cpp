// SPDX-License-Identifier: Apache-2.0
// Its port cannot be opened here, and it says so by a ComponentError, as it may: nothing of it is tried.
// fails: verdict
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  void open(binnacle::Reporter&) override { throw binnacle::ComponentError("there is no port /dev/none"); }
};

}  // namespace

BINNACLE_PLUGIN("open_refuses", "1.0.0", registry) { registry.add<Subject>(); }
