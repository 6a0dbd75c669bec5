// SPDX-License-Identifier: Apache-2.0
// A plugin with a global variable.
#include "entry.hpp"

int calls = 0;

extern "C" __attribute__((visibility("default"))) void binnacle_register_v1(void*) { ++calls; }
