// SPDX-License-Identifier: Apache-2.0
// Pieces of messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "binnacle/diagnostic.hpp"

namespace binnacle::internal::base {

inline std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// A letter of ASCII, a digit or one of the others.
constexpr bool is_word(char c, std::string_view others) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || others.find(c) != others.npos;
}

inline std::string joined(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// "a, b, c", cut after a dozen.
inline std::string listed(std::vector<std::string> names) {
  constexpr std::size_t most = 12;
  if (names.size() > most) {
    names.resize(most);
    names.emplace_back("…");
  }
  return joined(names, ", ");
}

/// "'a', 'b', 'c'", all of them.
inline std::string quoted_list(std::vector<std::string> names) {
  for (std::string& name : names) name = in_quotes(name);
  return joined(names, ", ");
}

/// "; did you mean 'x'?" or "".
inline std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string nearest = closest(name, candidates);
  return nearest.empty() ? "" : "; did you mean " + in_quotes(nearest) + "?";
}

/// The `name` of each.
template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.emplace_back(item.name);
  return names;
}

}  // namespace binnacle::internal::base
