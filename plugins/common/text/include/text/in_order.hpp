// SPDX-License-Identifier: Apache-2.0
// Leaves out of a record what does not stand in order of time.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace binnacle::text_file {

/// What increases in time stays. Where one is later than several after it, it is that one which is left out, else the one
/// after it. time_of(x); refuse(left out, its neighbour).
template <class T, class TimeOf, class Refuse>
std::vector<T> in_order(std::vector<T> all, TimeOf&& time_of, Refuse&& refuse) {
  std::vector<T> kept;
  kept.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kept.empty() || time_of(all[i]) > time_of(kept.back())) {
      kept.push_back(std::move(all[i]));
      continue;
    }
    const bool next_fits = i + 1 >= all.size() || time_of(all[i + 1]) > time_of(kept.back());
    const bool fits_before = kept.size() < 2 || time_of(all[i]) > time_of(kept[kept.size() - 2]);
    if (next_fits || !fits_before) {
      refuse(all[i], kept.back());
    } else {
      refuse(kept.back(), all[i]);
      kept.back() = std::move(all[i]);
    }
  }
  return kept;
}

}  // namespace binnacle::text_file
