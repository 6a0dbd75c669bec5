// SPDX-License-Identifier: Apache-2.0
// Messages of UBX, written by their documented places.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace binnacle::test {

class Content {
 public:
  explicit Content(std::size_t size) : bytes_(size, '\0') {}

  template <class T>
  Content& put(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof value);
    return *this;
  }
  Content& u1(std::size_t at, unsigned value) { return put(at, static_cast<std::uint8_t>(value)); }
  Content& u2(std::size_t at, unsigned value) { return put(at, static_cast<std::uint16_t>(value)); }
  Content& u4(std::size_t at, std::uint32_t value) { return put(at, value); }
  Content& i1(std::size_t at, int value) { return put(at, static_cast<std::int8_t>(value)); }
  Content& i2(std::size_t at, int value) { return put(at, static_cast<std::int16_t>(value)); }
  Content& i4(std::size_t at, std::int32_t value) { return put(at, value); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// B5 62, class and id, length, payload, checksum.
inline std::string ubx(int type, const std::string& payload) {
  std::string text = "\xB5\x62";
  text += static_cast<char>(type >> 8);
  text += static_cast<char>(type & 0xFF);
  text += static_cast<char>(payload.size() & 0xFF);
  text += static_cast<char>(payload.size() >> 8);
  text += payload;
  std::uint8_t a = 0, b = 0;
  for (std::size_t i = 2; i < text.size(); ++i) {
    a = static_cast<std::uint8_t>(a + static_cast<std::uint8_t>(text[i]));
    b = static_cast<std::uint8_t>(b + a);
  }
  text += static_cast<char>(a);
  text += static_cast<char>(b);
  return text;
}

/// What looks like a message gets the checksum that belongs to it, so that damage comes through to the payload.
inline std::string ubx_with_right_checksums(std::string bytes) {
  for (std::size_t at = 0; at + 8 <= bytes.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[at + i]); };
    const std::size_t size = byte(4) | static_cast<std::size_t>(byte(5)) << 8;
    if (byte(0) != 0xB5 || byte(1) != 0x62 || at + 8 + size > bytes.size()) {
      ++at;
      continue;
    }
    const std::string whole = ubx(byte(2) << 8 | byte(3), bytes.substr(at + 6, size));
    bytes.replace(at, whole.size(), whole);
    at += whole.size();
  }
  return bytes;
}

/// NAV-PVT with a 3D fix of 2025-08-28; iTOW [ms] and the time of day [s] of UTC belong to it.
inline Content pvt(std::uint32_t itow, int seconds_of_day) {
  Content p(92);
  p.u4(0, itow).u2(4, 2025).u1(6, 8).u1(7, 28);
  p.u1(8, static_cast<unsigned>(seconds_of_day / 3600)).u1(9, static_cast<unsigned>(seconds_of_day / 60 % 60));
  p.u1(10, static_cast<unsigned>(seconds_of_day % 60)).u1(11, 0x07).u4(12, 25);
  p.u1(20, 3).u1(21, 0x01 | 0x02 | 2 << 6).u1(23, 17);
  p.i4(24, -1051471665).i4(28, 400966916).i4(32, 1580048).i4(36, 1601435).u4(40, 14).u4(44, 10);
  p.i4(48, 1500).i4(52, -2500).i4(56, 300).i4(60, 2915).i4(64, 30096376).u4(68, 70).u4(72, 1234567).u2(76, 123);
  return p;
}

/// 17:30:22 UTC of that day, a Thursday: 4 days + 17:30:40 of GPS time.
inline constexpr int pvt_second = 17 * 3600 + 30 * 60 + 22;
inline constexpr std::uint32_t pvt_itow = (4 * 86400 + pvt_second + 18) * 1000u;

}  // namespace binnacle::test
