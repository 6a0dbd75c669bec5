// SPDX-License-Identifier: Apache-2.0
// Text that is put into XML, SVG or HTML.
#pragma once

#include <string>
#include <string_view>

namespace binnacle::wording {

/// As an element's text or a quoted attribute: "&lt;" and so on; what XML 1.0 does not allow becomes a blank.
inline std::string xml(std::string_view text) {
  std::string safe;
  for (const char c : text) switch (c) {
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '&': safe += "&amp;"; break;
      case '"': safe += "&quot;"; break;
      default: safe += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  return safe;
}

}  // namespace binnacle::wording
