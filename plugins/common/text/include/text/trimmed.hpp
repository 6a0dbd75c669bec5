// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace binnacle {

/// Without blanks at its ends.
inline std::string_view trimmed(std::string_view text, std::string_view blanks = " ") {
  const auto first = text.find_first_not_of(blanks);
  return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

}  // namespace binnacle
