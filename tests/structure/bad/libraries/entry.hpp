// SPDX-License-Identifier: Apache-2.0
// The guard and the list of types of a plugin, as far as they matter to the check of its symbols.
#pragma once

extern "C" __attribute__((visibility("default"))) const int binnacle_guard_v1;
const int binnacle_guard_v1 = 1;
extern "C" __attribute__((visibility("default"))) const char binnacle_types_v1[];
const char binnacle_types_v1[] = "still";
