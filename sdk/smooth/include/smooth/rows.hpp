// SPDX-License-Identifier: Apache-2.0
// Rows of a filter's covariance and of its measurements.
#pragma once

#include <algorithm>
#include <ranges>
#include <vector>

#include "binnacle/composition.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

/// Per row of P; empty where nothing is considered.
inline std::vector<unsigned char> considered_rows(const FilterInfo& filter) {
  using wording::as_size;
  std::vector<unsigned char> rows(as_size(filter.dof), 0);
  for (const BlockInfo& block : filter.blocks)
    for (std::size_t a = 0; a < block.active.size(); ++a)
      rows[as_size(block.first_row) + a] = block.use[as_size(block.active[a])] == "considered";
  if (std::ranges::find(rows, 1) == rows.end()) rows.clear();
  return rows;
}

inline int most_rows(const FilterInfo& filter) {
  int most = 1;
  for (const auto& measurement : filter.measurements) most = std::max(most, measurement.max_rows);
  return most;
}

}  // namespace binnacle::smooth
