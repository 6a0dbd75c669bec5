// SPDX-License-Identifier: Apache-2.0
// Numbers of some bits each, most significant first, as navigation messages have them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace binnacle::ublox {

/// `Size` bytes; bit 0 is the first one transmitted.
template <std::size_t Size>
struct Bits {
  std::array<std::uint8_t, Size> bytes{};

  std::uint32_t unsigned_at(std::size_t at, int count) const {
    std::uint32_t value = 0;
    for (std::size_t i = at; i < at + static_cast<std::size_t>(count); ++i)
      value = value << 1 | (bytes[i / 8] >> (7 - i % 8) & 1u);
    return value;
  }
  /// Two's complement.
  std::int32_t signed_at(std::size_t at, int count) const {
    const std::uint32_t value = unsigned_at(at, count);
    const std::uint32_t sign = std::uint32_t{1} << (count - 1);
    return static_cast<std::int32_t>((value ^ sign) - sign);
  }
  void set(std::size_t at, int count, std::uint32_t value) {
    for (int i = 0; i < count; ++i) {
      const std::size_t bit = at + static_cast<std::size_t>(i);
      const auto mask = static_cast<std::uint8_t>(1u << (7 - bit % 8));
      if (value >> (count - 1 - i) & 1u)
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] | mask);
      else
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] & ~mask);
    }
  }
};

/// Reads one number after the other.
template <std::size_t Size>
class BitReader {
 public:
  BitReader(const Bits<Size>& bits, std::size_t at) : bits_(bits), at_(at) {}
  void skip(int count) { at_ += static_cast<std::size_t>(count); }
  std::uint32_t u(int count) {
    const auto value = bits_.unsigned_at(at_, count);
    skip(count);
    return value;
  }
  /// × scale.
  double scaled(int count, double scale) { return u(count) * scale; }
  double scaled_signed(int count, double scale) {
    const double value = bits_.signed_at(at_, count) * scale;
    skip(count);
    return value;
  }

 private:
  const Bits<Size>& bits_;
  std::size_t at_;
};

}  // namespace binnacle::ublox
