// SPDX-License-Identifier: Apache-2.0
// Pieces of messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace binnacle::base {

inline std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

/// "a, b, c", cut after a dozen.
std::string listed(const std::vector<std::string>& names);

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
