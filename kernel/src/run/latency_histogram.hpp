// SPDX-License-Identifier: Apache-2.0
// How long things took: counts in bins that grow with the time, so that it needs no memory but its own.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "binnacle/time.hpp"

namespace binnacle::internal::runtime {

class LatencyHistogram {
 public:
  void add(Time latency) {
    const auto value = static_cast<std::uint64_t>(std::max<Time>(latency, 0));
    ++bins_[bin_of(value)];
    ++count_;
    longest_ = std::max(longest_, static_cast<Time>(value));
  }
  std::int64_t count() const { return count_; }
  Time longest() const { return longest_; }
  /// That a share of all did not exceed, from above by at most one part in 32; 0 where there is none.
  Time quantile(double share) const {
    const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count_)));
    std::int64_t found = 0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin)
      if ((found += bins_[bin]) >= wanted && found > 0) return std::min(end_of(bin), longest_);
    return longest_;
  }

 private:
  static constexpr int sub_bits = 5;  // of an octave: 32 bins
  static constexpr std::uint64_t sub = std::uint64_t{1} << sub_bits;

  static std::size_t bin_of(std::uint64_t value) {
    if (value < sub) return value;
    const auto shift = static_cast<int>(std::bit_width(value)) - 1 - sub_bits;
    return static_cast<std::size_t>(shift) * sub + (value >> shift);
  }
  /// The largest value in it.
  static Time end_of(std::size_t bin) {
    if (bin < sub) return static_cast<Time>(bin);
    const auto shift = bin / sub - 1;
    return static_cast<Time>(((bin - shift * sub + 1) << shift) - 1);
  }

  std::array<std::int64_t, (64 - sub_bits) * sub> bins_{};
  std::int64_t count_ = 0;
  Time longest_ = 0;
};

}  // namespace binnacle::internal::runtime
