// SPDX-License-Identifier: Apache-2.0
// Throws what it should refuse: its own smallest value.
// fails: robustness.parameters
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) {
    if (q == 0) throw std::runtime_error("division by zero");
  }
};

}  // namespace

BINNACLE_PLUGIN("throws_at_bounds", "1.0.0", registry) { registry.add<Subject>(); }
