// SPDX-License-Identifier: Apache-2.0
#include "start_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "chi_squared_score.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr double rare_at_start = 6;  // normal score of a probability of 1e-9

}  // namespace

void StartWatch::offered(const UpdateRecord& record) {
  First& first = first_[as_size(record.measurement)];
  if (first.t != no_time || record.rows == 0 || !std::isfinite(record.nis)) return;
  if (record.outcome != Outcome::accepted && record.outcome != Outcome::gated) return;
  first.t = record.t;
  first.nis = record.nis;
  first.rows = record.rows;
  double most = -1;
  for (int i = 0; i < record.rows; ++i) {
    const double sigma = std::sqrt(record.S(i, i)), ratio = std::abs(record.residual[i]) / sigma;
    if (!(ratio > most)) continue;
    most = ratio;
    first.group = record.row_groups ? record.row_groups[i] : 0;
    first.key = record.row_keys ? record.row_keys[i] : i;
    first.residual = record.residual[i];
    first.sigma = sigma;
  }
}

/// Its channel gives initial values to blocks, as they are, where its models compare it with a derived block.
bool StartWatch::starts_from_other_quantity(const MeasurementInfo& measurement) const {
  const bool gives_start = std::ranges::any_of(filter_.starts_when, [&](const InitialInfo& initial) {
    return initial.channel == measurement.channel;
  });
  const auto is_derived = [&](int port) { return port >= static_cast<int>(filter_.blocks.size()); };
  return gives_start && std::ranges::any_of(measurement.parts, [&](const auto& part) {
           return std::ranges::any_of(part.ports, is_derived);
         });
}

std::vector<std::string> StartWatch::notes(Time start) const {
  std::vector<std::string> notes;
  for (std::size_t m = 0; m < first_.size(); ++m) {
    const First& first = first_[m];
    if (first.t == no_time || chi_squared_score(first.nis / first.rows, first.rows) < rare_at_start) continue;
    const MeasurementInfo& measurement = filter_.measurements[m];
    const RowGroupInfo& group = measurement.groups[as_size(first.group)];
    char figures[160];
    std::snprintf(figures, sizeof figures, "%lld is %.3g %s from its prediction, %.0f sigma",
                  static_cast<long long>(first.key), first.residual, group.unit.c_str(),
                  std::abs(first.residual) / first.sigma);
    char when[32];
    std::snprintf(when, sizeof when, "%.3g s", seconds(first.t - start));
    std::string note = "the first sample of '" + measurement.name + "', " + when +
                       " after the start, contradicts the initial values and their sigmas: row " + group.name + " " +
                       figures;
    if (starts_from_other_quantity(measurement))
      note += "; '" + measurement.name +
              "' measures a derived block, but a state block starts at samples of the same channel as they are: its "
              "initial 'sigma' must cover the difference, such as a lever arm";
    notes.push_back(std::move(note));
  }
  return notes;
}

}  // namespace binnacle::score
