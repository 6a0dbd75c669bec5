// SPDX-License-Identifier: Apache-2.0
// Numbers of a message's payload, little-endian, by their place as the interface description has it.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <string_view>

namespace binnacle::ublox {

inline constexpr double degree = std::numbers::pi / 180;  // [rad]
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

static_assert(std::endian::native == std::endian::little);

class Payload {
 public:
  explicit Payload(std::string_view bytes) : bytes_(bytes) {}

  std::size_t size() const { return bytes_.size(); }
  std::uint8_t u1(std::size_t at) const { return get<std::uint8_t>(at); }
  std::int8_t i1(std::size_t at) const { return get<std::int8_t>(at); }
  std::uint16_t u2(std::size_t at) const { return get<std::uint16_t>(at); }
  std::int16_t i2(std::size_t at) const { return get<std::int16_t>(at); }
  std::uint32_t u4(std::size_t at) const { return get<std::uint32_t>(at); }
  std::int32_t i4(std::size_t at) const { return get<std::int32_t>(at); }
  float r4(std::size_t at) const { return get<float>(at); }
  double r8(std::size_t at) const { return get<double>(at); }
  bool bit(std::size_t at, int which) const { return (u1(at) >> which & 1) != 0; }

 private:
  template <class T>
  T get(std::size_t at) const {
    assert(at + sizeof(T) <= bytes_.size());
    T value;
    std::memcpy(&value, bytes_.data() + at, sizeof(T));
    return value;
  }
  std::string_view bytes_;
};

}  // namespace binnacle::ublox
