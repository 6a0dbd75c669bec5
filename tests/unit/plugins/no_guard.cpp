// SPDX-License-Identifier: Apache-2.0
// A shared library that is no plugin.
extern "C" __attribute__((visibility("default"), used)) void binnacle_register_v1() {}
