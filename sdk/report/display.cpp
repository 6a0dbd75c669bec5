// SPDX-License-Identifier: Apache-2.0
#include "display.hpp"

#include <algorithm>
#include <cmath>

#include "binnacle/unit.hpp"

namespace binnacle::report {

namespace {

Display in_unit(const std::string& si_unit, const std::string& unit) {
  const auto shown = parse_unit(unit);
  const auto si = parse_unit(si_unit);
  if (!shown || !si || !(shown->dimension == si->dimension)) return {si_unit == "1" ? "" : si_unit, 1};
  return {unit == "1" ? "" : unit, shown->scale / si->scale};
}

double largest(std::span<const double> values) {
  double most = 0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

}  // namespace

Display display_of(const std::string& si_unit, const std::string& wished, std::span<const double> values) {
  if (!wished.empty() && wished != si_unit) return in_unit(si_unit, wished);
  if (si_unit == "rad") return in_unit(si_unit, "deg");
  if (si_unit != "rad/s") return in_unit(si_unit, si_unit);
  const Display fast = in_unit(si_unit, "deg/s");
  return largest(values) < 0.1 * fast.scale ? in_unit(si_unit, "deg/h") : fast;
}

}  // namespace binnacle::report
