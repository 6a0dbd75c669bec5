// SPDX-License-Identifier: Apache-2.0
// Pieces of messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace binnacle::base {

inline std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// A letter of ASCII, a digit or one of the others.
constexpr bool is_word(char c, std::string_view others) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || others.find(c) != others.npos;
}

/// "a, b, c", cut after a dozen.
std::string listed(const std::vector<std::string>& names);

/// "'a', 'b', 'c'", all of them.
std::string quoted_list(const std::vector<std::string>& names);

/// "; did you mean 'x'?" or "".
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

/// The `name` of each.
template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace binnacle::base
