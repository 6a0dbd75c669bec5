// SPDX-License-Identifier: Apache-2.0
// JSON pointers (RFC 6901) as text.
#include "config/pointer.hpp"

namespace binnacle {

namespace config {

std::string escape_token(std::string_view token) {
  std::string text;
  for (const char c : token) {
    if (c == '~') {
      text += "~0";
    } else if (c == '/') {
      text += "~1";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace config

std::string join_pointer(std::string_view pointer, std::string_view token) {
  return std::string(pointer) + "/" + config::escape_token(token);
}

std::string join_pointer(std::string_view pointer, std::size_t index) {
  return std::string(pointer) + "/" + std::to_string(index);
}

namespace config {

std::optional<std::vector<std::string>> split_pointer(std::string_view pointer) {
  std::vector<std::string> tokens;
  for (std::size_t at = 0; at < pointer.size(); ++at) {
    if (pointer[at] == '/') {
      tokens.emplace_back();
    } else if (tokens.empty()) {
      return std::nullopt;
    } else if (pointer[at] != '~') {
      tokens.back() += pointer[at];
    } else {
      const char escaped = at + 1 < pointer.size() ? pointer[++at] : '\0';
      if (escaped != '0' && escaped != '1') return std::nullopt;
      tokens.back() += escaped == '0' ? '~' : '/';
    }
  }
  return tokens;
}

std::string parent_pointer(std::string_view pointer) {
  const std::size_t slash = pointer.rfind('/');
  return std::string(pointer.substr(0, slash == std::string_view::npos ? 0 : slash));
}

}  // namespace config

}  // namespace binnacle
