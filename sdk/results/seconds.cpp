// SPDX-License-Identifier: Apache-2.0
#include "results/seconds.hpp"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace binnacle::results {

double nearest_seconds(Time t) {
  constexpr Time exact = Time{1} << 53;
  if (t > -exact && t < exact) return static_cast<double>(t) / 1e9;  // both exact, the quotient rounded once
  char text[40];
  const auto magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  std::snprintf(text, sizeof text, "%s%llu.%09llu", t < 0 ? "-" : "",
                static_cast<unsigned long long>(magnitude / 1'000'000'000),
                static_cast<unsigned long long>(magnitude % 1'000'000'000));
  double s = 0;
  std::from_chars(text, text + std::strlen(text), s);
  return s;
}

}  // namespace binnacle::results
