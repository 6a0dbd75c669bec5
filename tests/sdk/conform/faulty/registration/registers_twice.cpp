// SPDX-License-Identifier: Apache-2.0
// Registers the same type twice.
// fails: load.register
#include "../faulty.hpp"

namespace faulty::registers_twice {

void add(Registry& registry) {
  registry.add<Process>();
  registry.add<Process>();
}

}  // namespace faulty::registers_twice
