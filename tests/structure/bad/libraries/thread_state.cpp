// SPDX-License-Identifier: Apache-2.0
// A plugin with state per thread.
#include "entry.hpp"

thread_local int calls = 0;

extern "C" __attribute__((visibility("default"))) void binnacle_register_v1(void*) { ++calls; }
