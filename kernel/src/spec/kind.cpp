// SPDX-License-Identifier: Apache-2.0
// Block kinds, part by part.
#include "spec/check.hpp"

#include <algorithm>
#include <optional>
#include <vector>

namespace binnacle::spec {

namespace {

std::vector<std::string_view> parts_of(std::string_view kind) {
  std::vector<std::string_view> parts;
  for (std::size_t end = kind.find(':'); end != kind.npos; end = kind.find(':')) {
    parts.push_back(kind.substr(0, end));
    kind.remove_prefix(end + 1);
  }
  parts.push_back(kind);
  return parts;
}

bool part_matches(std::string_view pattern, std::string_view part) {
  if (pattern == "*" || pattern == part) return true;
  const Parsed<Unit> wanted = parse_unit(pattern);
  const Parsed<Unit> had = parse_unit(part);
  return wanted && had && wanted->dimension == had->dimension;
}

}  // namespace

bool kind_matches(std::string_view pattern, std::string_view kind) {
  if (pattern == "*") return true;
  const std::vector<std::string_view> wanted = parts_of(pattern);
  const std::vector<std::string_view> had = parts_of(kind);
  if (wanted.size() != had.size()) return false;
  const bool first_matches = wanted.front() == "*" || wanted.front() == had.front();
  return first_matches && std::equal(wanted.begin() + 1, wanted.end(), had.begin() + 1, part_matches);
}

Parsed<std::string> canonical_kind(std::string_view kind) {
  const std::vector<std::string_view> parts = parts_of(kind);
  std::string canonical(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const Parsed<Unit> unit = parse_unit(parts[i]);
    const std::string si = unit ? si_unit(unit->dimension) : std::string(parts[i]);
    if (unit && unit->scale != 1.0) {
      return Parsed<std::string>::failure("a block's values are SI, so its unit cannot be '" + std::string(parts[i]) +
                                          "'; write '" + si + "'");
    }
    canonical += ":" + si;
  }
  return canonical;
}

}  // namespace binnacle::spec
