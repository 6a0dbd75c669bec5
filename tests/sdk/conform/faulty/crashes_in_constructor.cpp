// SPDX-License-Identifier: Apache-2.0
// Dies in its constructor.
// fails: metadata.example crash
#include "faulty.hpp"

namespace faulty::crashes_in_constructor {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) {
    volatile int* nowhere = nullptr;
    *nowhere = 1;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("crashes_in_constructor")); }

}  // namespace faulty::crashes_in_constructor
