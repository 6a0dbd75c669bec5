// SPDX-License-Identifier: Apache-2.0
// The guard symbol of a plugin, as far as it matters to the check of its symbols.
#pragma once

extern "C" __attribute__((visibility("default"))) const int binnacle_guard_v1;
const int binnacle_guard_v1 = 1;
