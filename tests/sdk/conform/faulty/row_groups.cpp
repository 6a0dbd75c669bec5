// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: it averages by group of rows, as Innovation::row_groups gives them.
// fails: nothing
#include <vector>

#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  void estimate(const binnacle::Innovation& in, binnacle::MatrixView R) const override {
    if (in.row_groups.size() != static_cast<std::size_t>(in.rows)) std::abort();
    Noise::estimate(in, R);
    for (const int group : in.row_groups)
      if (group != 0) std::abort();  // the kernel promises an index into NoiseBinding::groups
  }
};

}  // namespace

BINNACLE_PLUGIN("row_groups", "1.0.0", registry) { registry.add<Subject>(); }
