// SPDX-License-Identifier: Apache-2.0
// Parameters as JSON, put together member by member.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace binnacle::json_members {

using Json = nlohmann::ordered_json;
using Members = std::vector<std::pair<std::string, Json>>;

inline Json object(const Members& members) {
  Json all = Json::object();
  for (const auto& [name, member] : members) all[name] = member;
  return all;
}

/// `value` with member `name` set, replaced where it was.
inline Json with_member(Json value, const std::string& name, Json member) {
  value[name] = std::move(member);
  return value;
}

/// "0.25 m": a double survives to the bit.
inline std::string quantity(double value, const std::string& unit) { return Json(value).dump() + " " + unit; }

/// A unit of `factor` SI units.
inline std::string unit(const std::string& si, double factor = 1) { return factor == 1 ? si : quantity(factor, si); }

}  // namespace binnacle::json_members
