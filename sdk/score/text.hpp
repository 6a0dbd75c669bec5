// SPDX-License-Identifier: Apache-2.0
// Pieces of messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace binnacle::score {

inline std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

std::string in_quotes(std::string_view text);
/// "a, b, c", cut after a dozen.
std::string listed(const std::vector<std::string>& names);
/// "; did you mean 'x'?" or "".
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);
/// The place in the list; −1 where it is not in it.
int index_of(const std::vector<std::string>& names, std::string_view name);

/// The `name` of each.
template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace binnacle::score
