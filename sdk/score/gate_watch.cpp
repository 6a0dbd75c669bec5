// SPDX-License-Identifier: Apache-2.0
#include "gate_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr double rare_probability = 1e-6;     // probability of so many refusals, if all samples are right
constexpr double far_from_it = 0.1;           // NIS over its limit
constexpr std::int64_t enough_offered = 100;  // samples

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
  return text;
}

}  // namespace

double binomial_tail(std::int64_t n, std::int64_t k, double q) {
  if (k <= 0) return 1;
  const auto N = static_cast<double>(n), K = static_cast<double>(k);
  double term = std::exp(std::lgamma(N + 1) - std::lgamma(K + 1) - std::lgamma(N - K + 1) + K * std::log(q) +
                         (N - K) * std::log1p(-q));
  double sum = 0;
  for (double i = K; i <= N && term > 1e-9 * sum; ++i) {
    sum += term;
    term *= (N - i) / (i + 1) * q / (1 - q);
  }
  return std::min(1.0, sum);
}

void GateWatch::offered(const UpdateRecord& record) {
  const auto& measurement = filter_.measurements[as_size(record.measurement)];
  const auto& gate = measurement.gate;
  if (record.outcome != Outcome::accepted || gate.probability <= 0) return;
  double nis = 0;
  if (gate.by == "row") {
    for (int i = 0; i < record.rows; ++i) nis = std::max(nis, record.residual[i] * record.residual[i] / record.S(i, i));
  } else if (gate.by == "sample" && record.rows == measurement.max_rows) {
    nis = record.nis;
  } else {
    return;  // the limit of so many rows is not known here
  }
  Seen& seen = seen_[as_size(record.measurement)];
  ++seen.samples;
  seen.largest = std::max(seen.largest, nis / gate.nis_limit);
}

std::vector<std::string> GateWatch::notes(const std::vector<MeasurementCounts>& counts) const {
  std::vector<std::string> notes;
  for (std::size_t m = 0; m < counts.size(); ++m) {
    const auto& measurement = filter_.measurements[m];
    const auto& gate = measurement.gate;
    if (gate.probability <= 0) continue;
    const bool is_by_sample = gate.by == "sample";
    const auto of = [&](Outcome outcome) { return counts[m].by_outcome[static_cast<int>(outcome)]; };
    std::int64_t refused = is_by_sample ? of(Outcome::gated) : 0, used = is_by_sample ? of(Outcome::accepted) : 0;
    for (const auto& row : counts[m].rows) {
      if (is_by_sample) break;
      refused += row.refused;
      used += row.used;
    }
    const std::int64_t all = refused + used;
    const double expected = 1 - gate.probability, share = static_cast<double>(refused) / static_cast<double>(all);
    const std::string who = "the gate of '" + measurement.name + "' ";
    if (refused > 0 && share > expected && binomial_tail(all, refused, expected) < rare_probability)
      notes.push_back(who + "refused " + percent(share) + " (" + std::to_string(refused) + " of " +
                      std::to_string(all) + (is_by_sample ? " samples" : " rows") + ") where " + percent(expected) +
                      " was expected");
    if (refused == 0 && seen_[m].samples >= enough_offered && seen_[m].largest < far_from_it)
      notes.push_back(who + "was never near: the largest NIS of " + std::to_string(seen_[m].samples) + " samples is " +
                      percent(seen_[m].largest) + " of its limit");
  }
  return notes;
}

}  // namespace binnacle::score
