// SPDX-License-Identifier: Apache-2.0
// Its other file.
#include "alpha.hpp"

namespace alpha {
namespace {

double last = 0;  // bad

__extension__ using Wide = unsigned __int128;

double helper(double x, int n = 2) { return n * x; }

}  // namespace

int Model::instances_ = 0;  // bad

Model Model::spec() {
  Model model;
  model.example = R"json({"static": "int n;
    "mutable": [1, 2]})json";
  auto count = [n = 0]() mutable { return ++n; };  // bad
  count();
  return model;
}

}  // namespace alpha

BINNACLE_PLUGIN("alpha", "1.0.0", registry) { registry.add<alpha::Model>(); }
