// SPDX-License-Identifier: Apache-2.0
// A plugin that pretends to have been built in another world, and notes if any of its code ever runs.
#include <cstdlib>

#include "components.hpp"

namespace {

constexpr binnacle::abi::Guard pretended() {
  auto guard = binnacle::abi::make_guard("wrong_guard", "9");
  guard.standard_library_abi ^= 1;
  guard.debug_containers = 1;
  guard.sanitizers ^= binnacle::abi::address_sanitizer;
  guard.types[0].size = 8;
  guard.types[3] = {72, 4};
  guard.instruction_sets = 1ull << 63;
  guard.eigen_version = 30000;
  guard.eigen_max_align = 64;
  guard.header_hash = 0xabc;
  guard.container_assertions ^= 1;
  for (char& c : guard.compiler) c = '\0';
  guard.compiler[0] = 'X';
  return guard;
}

__attribute__((constructor)) void note() { setenv("BINNACLE_TEST_CODE_RAN", "1", 1); }

}  // namespace

extern "C" __attribute__((visibility("default"))) const binnacle::abi::Guard binnacle_guard_v1;
constexpr binnacle::abi::Guard binnacle_guard_v1 = pretended();
extern "C" __attribute__((visibility("default"), used)) void binnacle_register_v1(binnacle::Registry&) { note(); }
