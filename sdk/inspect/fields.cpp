// SPDX-License-Identifier: Apache-2.0
// Fields of one channel: no numbers, constant, stuck, quantized, clipped, spikes, standard deviations that cannot be.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "questions.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

namespace {

Finding finding(const Channel& channel, const Field& field, std::string kind, double value, std::string unit) {
  Finding found;
  found.kind = std::move(kind);
  found.channel = channel.name;
  found.field = field.name;
  found.value = value;
  found.unit = std::move(unit);
  found.severity = Severity::warning;
  return found;
}

/// What models of navigation subscribe to: a receiver's flags and counts may stand still, or jump.
bool is_measured(const Field& field) {
  static const std::vector<std::string> names{"wx",  "wy",  "wz",     "fx", "fy", "fz",
                                              "lat", "lon", "height", "vn", "ve", "vd"};
  return std::ranges::find(names, field.name) != names.end();
}

bool is_deviation(const Field& field) { return field.name.find("_sd_") != std::string::npos; }

void ask_numbers(const Channel& channel, const Field& field, Findings& findings) {
  const auto count = field.empty + field.bad;
  if (count == 0) return;
  Finding found = finding(channel, field, "nan", static_cast<double>(count), "");
  for (std::size_t i = 0; i < field.values.size(); ++i)
    if (!std::isfinite(field.values[i])) {
      found.to = channel.t[i];
      if (!std::isfinite(found.from)) found.from = channel.t[i];
    }
  found.text =
      fmt::format("{} cells are no number ({} empty), the first at {} s", count, field.empty, figure(found.from));
  found.evidence = "cells of the column";
  const bool are_some_spoilt = field.spoilt > 0 && 20 * field.spoilt < static_cast<std::int64_t>(field.values.size());
  found.meaning = are_some_spoilt ? source_patch(channel, {{"invalid_rows", "skip"}})
                                  : column_patch(channel, {field.name}, {{"missing", {"nan", ""}}});
  findings.push_back(std::move(found));
}

/// The longest run of one value.
struct Run {
  std::size_t from = 0, length = 0;
};

std::pair<Run, Run> longest_runs(const std::vector<double>& values) {
  Run first, second;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i + 1;
    while (end < values.size() && values[end] == values[i]) ++end;
    const Run run{i, end - i};
    if (run.length > first.length) {
      second = first;
      first = run;
    } else if (run.length > second.length) {
      second = run;
    }
    i = end;
  }
  return {first, second};
}

/// Whether another field of the channel (of the same kind) changes during the run.
bool others_change(const Channel& channel, const Field& field, const Run& run) {
  for (const Field& other : channel.fields) {
    if (&other == &field || is_deviation(other)) continue;
    std::size_t changes = 0;
    for (std::size_t i = run.from + 1; i < run.from + run.length; ++i)
      changes += other.values[i] != other.values[i - 1];
    if (2 * changes > run.length) return true;
  }
  return false;
}

/// True: the field never changes.
bool ask_constant(const Channel& channel, const Field& field, Findings& findings) {
  const auto [first, second] = longest_runs(field.values);
  const std::size_t n = field.values.size();
  if (n < 20 || first.length < 2) return false;
  const bool is_constant = first.length == n;
  // Runs by chance have a geometric distribution: one five times as long as the next longest, and above 50, has p < 1e-6 with
  // the shares of equal neighbours (below 0.75) that quantized sensors have.
  const bool is_stuck = channel.is_inertial() && first.length > 50 && first.length > 5 * second.length;
  if (!is_constant && !(is_stuck && others_change(channel, field, first))) return false;
  if (is_constant && !is_measured(field)) return true;
  Finding found = finding(channel, field, is_constant ? "constant" : "stuck", field.values[first.from], field.si);
  found.from = channel.t[first.from];
  found.to = channel.t[first.from + first.length - 1];
  found.text = fmt::format("is {} {} {} from {} s to {} s, while others change", figure(found.value), field.si,
                           is_constant ? "all the time," : "throughout", figure(found.from), figure(found.to));
  found.evidence = fmt::format("{} equal values in a row; the next longest run has {}", first.length, second.length);
  findings.push_back(std::move(found));
  return is_constant;
}

void ask_steps_of_value(const Channel& channel, const Field& field, Findings& findings) {
  if (is_deviation(field) || field.si.empty() || field.name == "lat" || field.name == "lon") return;
  std::map<double, std::size_t> levels;
  for (const double value : field.values)
    if (std::isfinite(value) && levels.size() < 20'000) ++levels[value];
  if (levels.size() < 4 || levels.size() >= 20'000) return;
  std::vector<double> steps;
  for (auto at = std::next(levels.begin()); at != levels.end(); ++at) steps.push_back(at->first - std::prev(at)->first);
  const double step = median(steps);
  // Of the quieter half of the record, in stretches of 100 samples.
  std::vector<double> shares;
  for (std::size_t first = 0; first + 100 < field.values.size(); first += 100) {
    double same = 0;
    for (std::size_t i = first + 1; i <= first + 100; ++i) same += field.values[i] == field.values[i - 1];
    shares.push_back(same / 100);
  }
  const double share = shares.empty() ? 0 : quantile(shares, 0.75);
  // Where two thirds of neighbours are equal, the step is above 2 sigma of what is between them: the noise no longer
  // carries the signal across a step, and errors of rounding are not white.
  const bool is_coarse = channel.is_inertial() && share > 0.67;
  Finding found = finding(channel, field, "quantized", step, field.si);
  found.severity = is_coarse ? Severity::warning : Severity::finding;
  found.text = fmt::format("in steps of {} {}; {} % of neighbours are equal where it is quiet", figure(step), field.si,
                           figure(100 * share));
  found.evidence = fmt::format("{} different values", levels.size());
  if (is_coarse || (channel.is_inertial() && levels.size() < 5'000)) findings.push_back(std::move(found));
}

/// Values pile up at an end of the range: at the last level far more than at the five before.
void ask_clipped(const Channel& channel, const Field& field, Findings& findings) {
  if (!channel.is_inertial() || field.values.size() < 1000) return;
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> sorted;
    for (const double value : field.values)
      if (std::isfinite(value)) sorted.push_back(sign * value);
    std::ranges::sort(sorted, std::greater<>());
    if (sorted.empty() || sorted.front() == sorted.back()) continue;
    std::vector<std::size_t> counts{0};
    for (std::size_t i = 0; i < sorted.size() && counts.size() <= 6; ++i) {
      if (i && sorted[i] != sorted[i - 1]) counts.push_back(0);
      ++counts.back();
    }
    std::size_t next = 0;
    for (std::size_t i = 1; i + 1 < counts.size(); ++i) next = std::max(next, counts[i]);
    // A Poisson count of the next levels' size would need more than ten sigma.
    if (counts.size() < 6 ||
        static_cast<double>(counts[0]) < 10 + static_cast<double>(next) + 10 * std::sqrt(static_cast<double>(next) + 1))
      continue;
    Finding found = finding(channel, field, "clipped", sign * sorted.front(), field.si);
    for (std::size_t i = 0; i < field.values.size(); ++i)
      if (field.values[i] == found.value) {
        found.to = channel.t[i];
        if (!std::isfinite(found.from)) found.from = channel.t[i];
      }
    found.text =
        fmt::format("is cut off at {} {}: {} samples have just this value", figure(found.value), field.si, counts[0]);
    found.evidence = fmt::format("the five next values have {} at most", next);
    findings.push_back(std::move(found));
  }
}

/// Single samples far from both neighbours, which agree with each other.
void ask_spikes(const Channel& channel, const Field& field, Findings& findings) {
  // Positions are compared with velocities instead.
  if (!is_measured(field) || field.name == "lat" || field.name == "lon") return;
  const auto& x = field.values;
  double limit = 0;
  const auto rows = spikes(x, limit);
  const std::size_t count = rows.size();
  if (count == 0) return;
  const std::size_t worst = rows.front();
  Finding found = finding(channel, field, "spike", x[worst] - 0.5 * (x[worst - 1] + x[worst + 1]), field.si);
  found.from = found.to = channel.t[worst];
  found.text = fmt::format("{} sample{} away from both neighbours, by {} {} at {} s", count, count == 1 ? "" : "s",
                           figure(found.value), field.si, figure(found.from));
  found.evidence = fmt::format("limit {} {}: what the tail of the record's own roughness reaches once in 10^4 records",
                               figure(limit), field.si);
  findings.push_back(std::move(found));
}

void ask_zero_deviation(const Channel& channel, const Field& field, Findings& findings) {
  std::size_t count = 0, first = 0;
  for (std::size_t i = field.values.size(); i-- > 0;)
    if (field.values[i] <= 0) {
      ++count;
      first = i;
    }
  if (count == 0) return;
  Finding found = finding(channel, field, "zero_deviation", static_cast<double>(count), "");
  found.from = channel.t[first];
  found.text = fmt::format("{} standard deviations are not above zero, the first at {} s", count, figure(found.from));
  found.evidence = "values of the column";
  found.meaning = column_patch(channel, {field.name}, {{"missing", {"0"}}});
  findings.push_back(std::move(found));
}

}  // namespace

void ask_fields(const Channel& channel, Findings& findings) {
  for (const Field& field : channel.fields) {
    ask_numbers(channel, field, findings);
    if (is_deviation(field)) ask_zero_deviation(channel, field, findings);
    if (ask_constant(channel, field, findings)) continue;
    ask_clipped(channel, field, findings);
    ask_steps_of_value(channel, field, findings);
    ask_spikes(channel, field, findings);
  }
}

}  // namespace binnacle::inspect
