// SPDX-License-Identifier: Apache-2.0
// JSON pointers (RFC 6901) as text.
#include "config/pointer.hpp"

#include <algorithm>
#include <charconv>

#include <nlohmann/json.hpp>

namespace binnacle {

using Pointer = nlohmann::ordered_json::json_pointer;

std::string join_pointer(std::string_view pointer, std::string_view token) {
  return std::string(pointer) + (Pointer() / std::string(token)).to_string();
}

std::string join_pointer(std::string_view pointer, std::size_t index) {
  return std::string(pointer) + "/" + std::to_string(index);
}

namespace config {

std::optional<std::vector<std::string>> split_pointer(std::string_view pointer) {
  try {
    std::vector<std::string> tokens;
    for (Pointer rest{std::string(pointer)}; !rest.empty(); rest.pop_back()) tokens.push_back(rest.back());
    std::reverse(tokens.begin(), tokens.end());
    return tokens;
  } catch (const nlohmann::ordered_json::parse_error&) {
    return std::nullopt;
  }
}

std::optional<std::size_t> index_in(std::size_t size, std::string_view token) {
  std::size_t index = 0;
  const auto [last, status] = std::from_chars(token.data(), token.data() + token.size(), index);
  const bool is_number = status == std::errc() && last == token.data() + token.size();
  return is_number && index < size ? std::optional(index) : std::nullopt;
}

}  // namespace config

}  // namespace binnacle
