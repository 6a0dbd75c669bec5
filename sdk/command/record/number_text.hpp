// SPDX-License-Identifier: Apache-2.0
// Numbers as text: what std::to_chars gives to so many digits, without its zeros at the end.
#pragma once

#include <cstddef>

#include "binnacle/time.hpp"

namespace binnacle::command {

/// What a number is written to.
struct Digits {
  int decimals =
      shortest;  // most_decimals at most; exact: as few digits as read back to the same double; none: significant ones alone
  int significant = 6;  // where fewer would remain of a small number; most_significant at most

  static constexpr int shortest = -1, none = -2, most_decimals = 12, most_significant = 8;
};

/// No number takes more characters, nor does put_number() touch more.
inline constexpr std::size_t longest_number = 352;

/// Writes at `at`, returns the end. Within half a unit of the last digit, ties as std::to_chars has them.
char* put_number(char* at, double value, Digits digits);

/// Nanoseconds as seconds with nine decimals, by integers only.
char* put_seconds(char* at, Time t);

}  // namespace binnacle::command
