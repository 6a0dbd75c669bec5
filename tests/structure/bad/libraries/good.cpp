// SPDX-License-Identifier: Apache-2.0
// A plugin without fault: what the tool chain adds to it, the check passes over.
#include <iostream>
#include <stdexcept>
#include <string>

#include "entry.hpp"

struct Base {
  virtual ~Base() = default;
  virtual int rows(int n) const = 0;
};
struct Model : Base {
  int rows(int n) const override {
    if (n < 0) throw std::invalid_argument("rows");
    return n + 1;
  }
};
const char* const names[] = {"one", "two"};

extern "C" __attribute__((visibility("default"))) void binnacle_register_v1(void* p) {
  try {
    const Model model;
    *static_cast<std::string*>(p) = names[model.rows(*static_cast<int*>(p)) & 1];
  } catch (const std::exception&) {
  }
}
