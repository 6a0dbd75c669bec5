// SPDX-License-Identifier: Apache-2.0
// Throws where it should register.
// fails: load.register
#include "../faulty.hpp"

namespace faulty::throws_at_registration {

void add(Registry& registry) {
  registry.add<Process>();
  throw 7;
}

}  // namespace faulty::throws_at_registration
