// SPDX-License-Identifier: Apache-2.0
// Pieces of messages, and the lists of names that they are made of.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/diagnostic.hpp"

namespace binnacle::wording {

inline std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

inline std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

/// "a, b, c", cut after a dozen; "none" where there is none.
inline std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 12;
  std::string list = names.empty() ? "none" : "";
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == most) return list + ", …";
    list += (i ? ", " : "") + names[i];
  }
  return list;
}

/// "; did you mean 'x'?" or "".
inline std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string nearest = closest(name, candidates);
  return nearest.empty() ? "" : "; did you mean " + in_quotes(nearest) + "?";
}

/// The place in the list; −1 where it is not in it.
inline int index_of(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

/// The `name` of each.
template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace binnacle::wording
