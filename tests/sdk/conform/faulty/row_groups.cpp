// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: it averages by group of rows, as Innovation::row_groups gives them.
// fails: nothing
#include <vector>

#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  void estimate(const binnacle::Innovation& innovation, std::byte* memory, binnacle::MatrixView R) const override {
    if (innovation.row_groups.size() != static_cast<std::size_t>(innovation.rows)) std::abort();
    Noise::estimate(innovation, memory, R);
    for (const int group : innovation.row_groups)
      if (group != 0) std::abort();  // the kernel promises an index into NoiseBinding::groups
  }
};

}  // namespace

BINNACLE_PLUGIN("row_groups", "1.0.0", registry) { registry.add<Subject>(); }
