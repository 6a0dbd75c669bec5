// SPDX-License-Identifier: Apache-2.0
// Columns: the numbers behind the plots, as text that a page can carry.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace binnacle::report {

using Json = nlohmann::ordered_json;

std::string base64(std::string_view bytes);

/// Equal columns are kept once.
class Columns {
 public:
  /// 64-bit floating point: times.
  int exact(std::span<const double> values);
  /// 32 bits: seven digits of what a plot shows.
  int plotted(std::span<const double> values);
  int bytes(std::span<const std::uint8_t> values);

  std::size_t size() const { return list_.size(); }
  /// [ { "f8" | "f4" | "u1": base64, "o": offset of f4 } ]
  Json json() && { return std::move(list_); }

 private:
  int add(const char* type, std::string_view bytes, double offset);

  std::unordered_multimap<std::size_t, int> known_;  // by the hash of their text
  Json list_ = Json::array();
};

}  // namespace binnacle::report
