// SPDX-License-Identifier: Apache-2.0
// A plugin of a later major version.
extern "C" __attribute__((visibility("default"))) const int binnacle_guard_v2;
const int binnacle_guard_v2 = 2;
extern "C" __attribute__((visibility("default"), used)) void binnacle_register_v2() {}
