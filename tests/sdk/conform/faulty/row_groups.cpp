// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: it averages by group of rows, as Innovation::row_groups gives them.
// fails: nothing
#include <vector>

#include "faulty.hpp"

namespace faulty::row_groups {

class Subject final : public Noise {
 public:
  using Noise::Noise;
  void estimate(const Innovation& in, MatrixView R) const override {
    if (in.row_groups.size() != static_cast<std::size_t>(in.rows)) std::abort();
    Noise::estimate(in, R);
    for (const int group : in.row_groups)
      if (group != 0) std::abort();  // the kernel promises an index into NoiseBinding::groups
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("row_groups")); }

}  // namespace faulty::row_groups
