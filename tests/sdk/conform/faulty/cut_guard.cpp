// SPDX-License-Identifier: Apache-2.0
// Its guard is shorter than this version's.
// fails: load.guard
#include "faulty.hpp"

namespace {
constexpr binnacle::abi::Guard made = binnacle::abi::make_guard("cut_guard", "1.0.0");
}
extern "C" __attribute__((visibility("default"))) const binnacle::abi::Guard binnacle_guard_v1;
constexpr binnacle::abi::Guard altered() {
  binnacle::abi::Guard guard = made;
  guard.size -= 4;
  return guard;
}
const binnacle::abi::Guard binnacle_guard_v1 = altered();
extern "C" __attribute__((visibility("default"), used)) void binnacle_register_v1(binnacle::Registry& registry) {
  registry.add<faulty::Process>();
}
