// SPDX-License-Identifier: Apache-2.0
// A heading by the course.
#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/format.h>

#include "questions.hpp"

namespace binnacle::inspect {

namespace {

struct HeadingFit {
  double sign = 1, factor = 1, offset = 0, length = -1;  // of the mean direction: 1 where all agree
};

HeadingFit best_fit(const Field& field, const Fixes& fixes, const std::vector<std::size_t>& rows, std::size_t& used) {
  HeadingFit best;
  for (const double sign : {1.0, -1.0})
    for (const double factor : {1.0, 1 / degrees, degrees}) {
      std::complex<double> sum = 0;
      std::size_t n = 0;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const double heading = field.values[rows[i]];
        if (!(std::hypot(fixes.v[i][0], fixes.v[i][1]) > 5) || !std::isfinite(heading)) continue;
        sum += std::polar(1.0, sign * factor * heading - std::atan2(fixes.v[i][1], fixes.v[i][0]));
        ++n;
      }
      used = n;
      const double length = n ? std::abs(sum) / static_cast<double>(n) : 0;
      if (length > best.length + 0.02) best = {sign, factor, std::arg(sum), length};
    }
  return best;
}

}  // namespace

void ask_heading(const Channel& channel, const Fixes& fixes, Findings& findings) {
  const Field* const field = channel.find("yaw") ? channel.find("yaw") : channel.find("course");
  if (!field || !fixes.has_velocity || field->si != "rad") return;
  const auto rows = rows_in_order(channel.t);
  std::size_t used = 0;
  const HeadingFit best = best_fit(*field, fixes, rows, used);
  Finding found;
  found.kind = "heading";
  found.channel = channel.name;
  found.field = field->name;
  found.value = best.offset * degrees;
  found.unit = "deg";
  found.evidence =
      fmt::format("against the course above 5 m/s in {} fixes: mean direction of length {}", used, figure(best.length));
  if (used < 30 || best.length < 0.8) {
    found.severity = used < 30 ? Severity::unknown : Severity::warning;
    found.text = used < 30 ? "too little driving to compare the heading with the course" : "does not follow the course";
    findings.push_back(std::move(found));
    return;
  }
  const bool has_unit = best.factor == 1, has_sign = best.sign > 0;
  const double off = std::abs(best.offset) * degrees;
  // Circular standard deviation over the root of independent stretches of 10 s.
  const double error = degrees * std::sqrt(std::max(0.0, -2 * std::log(best.length))) /
                       std::sqrt(1 + static_cast<double>(used) * fixes.step / 10);
  const bool is_off = off > 3 && off > 5 * error;
  found.severity = has_unit && has_sign && !is_off ? Severity::finding : Severity::warning;
  found.kind = !has_unit ? "heading_unit" : !has_sign ? "heading_sense" : is_off ? "heading_offset" : "heading";
  found.confidence = 0.99;
  const char* const unit = best.factor < 1 ? "deg" : best.factor > 1 ? "rad" : field->unit.c_str();
  found.text = !has_unit   ? fmt::format("numbers are in {}, not {}", unit, field->unit)
               : !has_sign ? fmt::format("turns the other way round than the course, and is {} deg where that is 0",
                                         figure(-found.value))
               : is_off    ? fmt::format("is {} deg off the course (+- {})", figure(found.value), figure(error))
                           : fmt::format("follows the course, {} deg off (+- {})", figure(found.value), figure(error));
  if (!has_unit) {
    found.value = best.factor * field->scale;
    found.unit = unit;
    found.meaning = column_patch(channel, {field->name}, {{"unit", unit}});
  } else if (!has_sign) {
    found.meaning = column_patch(channel, {field->name},
                                 {{"scale", -1}, {"offset", fmt::format("{:.2f} deg", -best.offset * degrees)}});
  } else if (is_off) {
    found.meaning =
        column_patch(channel, {field->name}, {{"offset", fmt::format("{:.2f} deg", -best.offset * degrees)}});
  }
  findings.push_back(std::move(found));
}

}  // namespace binnacle::inspect
