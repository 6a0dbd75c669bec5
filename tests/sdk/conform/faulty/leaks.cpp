// SPDX-License-Identifier: Apache-2.0
// Forgets a thousand bytes each time it is made.
// fails: life.leaks
#include "faulty.hpp"

namespace faulty::leaks {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) { forgotten_ = new char[1000]; }

 private:
  char* volatile forgotten_ = nullptr;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("leaks")); }

}  // namespace faulty::leaks
