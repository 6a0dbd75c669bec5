// SPDX-License-Identifier: Apache-2.0
// A plugin that was built for a newer minor version of the API.
#include "components.hpp"

namespace {

constexpr binnacle::abi::Guard pretended() {
  auto guard = binnacle::abi::make_guard("newer", "1");
  ++guard.api_minor;
  return guard;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const binnacle::abi::Guard binnacle_guard_v1;
constexpr binnacle::abi::Guard binnacle_guard_v1 = pretended();
extern "C" __attribute__((visibility("default"), used)) void binnacle_register_v1(binnacle::Registry& registry) {
  registry.add<loader_test::Still>();
}
