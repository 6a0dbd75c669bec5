// SPDX-License-Identifier: Apache-2.0
// Forgets a thousand bytes each time it is made.
// fails: life.leaks
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) { forgotten_ = new char[1000]; }

 private:
  char* volatile forgotten_ = nullptr;
};

}  // namespace

BINNACLE_PLUGIN("leaks", "1.0.0", registry) { registry.add<Subject>(); }
