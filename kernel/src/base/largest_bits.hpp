// SPDX-License-Identifier: Apache-2.0
// Whether many numbers are in a range, by one comparison each.
#pragma once

#include <bit>
#include <cstdint>

namespace binnacle::internal::base {

/// Of numbers from +0 up to +∞ the bits are ordered as they are; those of all others, not a number among them, are larger.
class LargestBits {
 public:
  void take(double number) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    bits_ = bits > bits_ ? bits : bits_;
  }
  /// All are in [+0, limit). What is −0 is not.
  bool are_below(double limit) const { return bits_ < std::bit_cast<std::uint64_t>(limit); }

 private:
  std::uint64_t bits_ = 0;
};

}  // namespace binnacle::internal::base
