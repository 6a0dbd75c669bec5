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

/// What a terminal would obey becomes visible: ESC is "\x1b". `kept` stays as it is. Control characters of Unicode count
/// (C1, two bytes in UTF-8), which a terminal obeys as it does ESC.
inline std::string visible(std::string_view text, std::string_view kept = "") {
  constexpr const char* digits = "0123456789abcdef";
  std::string safe;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool is_c1 = c == 0xC2 && i + 1 < text.size() && (static_cast<unsigned char>(text[i + 1]) & 0xE0) == 0x80;
    const auto code = is_c1 ? static_cast<unsigned char>(text[++i]) : c;
    if (is_c1 || ((c < 0x20 || c == 0x7F) && kept.find(text[i]) == kept.npos))
      safe += std::string("\\x") + digits[code >> 4] + digits[code & 15];
    else
      safe += text[i];
  }
  return safe;
}

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
