// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace binnacle::results {

std::string identifier(std::string_view text) {
  std::string name;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    name += is_plain ? c : '_';
  }
  // MATLAB and Python take no digit in front.
  if (name.empty() || (name[0] >= '0' && name[0] <= '9')) name.insert(0, "_");
  return name;
}

std::string Names::take(std::string_view text) {
  const std::string wanted = identifier(text);
  std::string name = wanted;
  for (int n = 2; !taken_.insert(name).second; ++n) name = wanted + "_" + std::to_string(n);
  return name;
}

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
