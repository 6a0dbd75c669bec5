// SPDX-License-Identifier: Apache-2.0
// Numbers and times as text that is read back as the same.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <string>

#include "binnacle/time.hpp"

namespace binnacle::numbers {

/// As many digits as it takes to read the same number again; "nan" and "inf" too.
inline void append_number(std::string& text, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}

/// Nanoseconds as seconds, exactly: "12.5", "-0.01", "3.0".
inline void append_seconds(std::string& text, Time t) {
  const auto magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  std::array<char, 20> digits;
  if (t < 0) text += '-';
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), magnitude / 1'000'000'000).ptr);
  std::uint64_t rest = magnitude % 1'000'000'000;
  text += '.';
  for (std::uint64_t place = 100'000'000; rest > 0; rest %= place, place /= 10)
    text += static_cast<char>('0' + rest / place);
  if (text.back() == '.') text += '0';
}

}  // namespace binnacle::numbers
