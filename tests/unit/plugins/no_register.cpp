// SPDX-License-Identifier: Apache-2.0
// A guard with nothing behind it.
#include "binnacle/abi.hpp"

extern "C" __attribute__((visibility("default"))) const binnacle::abi::Guard binnacle_guard_v1;
const binnacle::abi::Guard binnacle_guard_v1 = binnacle::abi::make_guard("no_register", "1");
