// SPDX-License-Identifier: Apache-2.0
// Values that stand for one that is not there.
#pragma once

#include <limits>
#include <string>

#include <nlohmann/json.hpp>

namespace binnacle::report {

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

inline const nlohmann::ordered_json& at_or_null(const nlohmann::ordered_json& object, const std::string& key) {
  static const nlohmann::ordered_json null;
  if (!object.is_object()) return null;
  const auto found = object.find(key);
  return found == object.end() ? null : *found;
}

}  // namespace binnacle::report
