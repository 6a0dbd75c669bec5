// SPDX-License-Identifier: Apache-2.0
// A plugin with state inside a function, initialized data.
#include "entry.hpp"

extern "C" __attribute__((visibility("default"))) void binnacle_register_v1(void* p) {
  static double sum = 1;
  sum += *static_cast<double*>(p);
  *static_cast<double*>(p) = sum;
}
