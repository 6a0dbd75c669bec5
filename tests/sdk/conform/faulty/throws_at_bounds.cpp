// SPDX-License-Identifier: Apache-2.0
// Throws what it should refuse: its own smallest value.
// fails: robustness.parameters
#include "faulty.hpp"

namespace faulty::throws_at_bounds {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) {
    if (q == 0) throw std::runtime_error("division by zero");
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("throws_at_bounds")); }

}  // namespace faulty::throws_at_bounds
