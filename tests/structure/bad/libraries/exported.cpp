// SPDX-License-Identifier: Apache-2.0
// A plugin that exports one symbol too many; it is linked without the version script.
#include "entry.hpp"

extern "C" __attribute__((visibility("default"))) void binnacle_extra() {}
extern "C" __attribute__((visibility("default"))) void binnacle_register_v1(void*) {}
