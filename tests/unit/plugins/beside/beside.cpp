// SPDX-License-Identifier: Apache-2.0
// What the plugin looks_beside finds beside itself.
extern "C" int binnacle_test_beside();
int binnacle_test_beside() { return 7; }
