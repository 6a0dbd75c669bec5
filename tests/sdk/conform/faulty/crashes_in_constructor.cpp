// SPDX-License-Identifier: Apache-2.0
// Dies in its constructor.
// fails: metadata.example crash
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) {
    volatile int* nowhere = nullptr;
    *nowhere = 1;
  }
};

}  // namespace

BINNACLE_PLUGIN("crashes_in_constructor", "1.0.0", registry) { registry.add<Subject>(); }
