// SPDX-License-Identifier: Apache-2.0
// What became of a filter's samples, as the summary of a run shows it.
#include "run_figures.hpp"

namespace binnacle::score {

namespace {

using Json = nlohmann::ordered_json;

/// Rows that a gate by row or key took out of accepted samples: in all, and which.
Json left_out(const MeasurementInfo& info, const MeasurementCounts& counts) {
  const bool names_group = info.gate.by == "row" && info.groups.size() > 1;
  Json by_key = Json::object();
  for (const auto& entry : counts.left_out) {
    const std::string key = std::to_string(entry.key);
    by_key[names_group ? info.groups[static_cast<std::size_t>(entry.group)].name + " " + key : key] = entry.count;
  }
  return {{"rows", counts.rows_left_out},
          {"of", counts.rows_used + counts.rows_left_out},
          {"by_key", std::move(by_key)}};
}

Json measurement_figures(const MeasurementInfo& info, const MeasurementCounts& counts) {
  static constexpr const char* names[outcome_count] = {"accepted", "gated",    "late",    "unsupported",
                                                       "invalid",  "withheld", "rejected"};
  Json figures;
  figures["offered"] = counts.offered;
  for (int o = 0; o < outcome_count; ++o) figures[names[o]] = counts.by_outcome[o];
  figures["before_start"] = counts.before_start;
  if (info.recovers) figures["recoveries"] = counts.recoveries;
  if (info.gate.by == "row" || info.gate.by == "key") figures["left_out"] = left_out(info, counts);
  if (counts.nis_count > 0) {
    figures["nis_mean"] = counts.nis_mean;
    figures["dof"] = counts.dof_mean;
  } else {
    figures["nis_mean"] = nullptr;
    figures["dof"] = info.max_rows;
  }
  if (!counts.last_reason.empty()) figures["last_reason"] = counts.last_reason;
  return figures;
}

}  // namespace

Json run_figures(const Session& session, FilterId filter) {
  const auto& measurements = session.composition().filters()[static_cast<std::size_t>(filter.index)].measurements;
  Json figures{{"measurements", Json::object()}};
  for (std::size_t m = 0; m < measurements.size(); ++m)
    figures["measurements"][measurements[m].name] =
        measurement_figures(measurements[m], session.counts(MeasurementId{filter, static_cast<int>(m)}));
  if (session.started(filter)) {
    figures["start_s"] = seconds(session.start_time(filter));
    figures["end_s"] = seconds(session.time(filter));
  }
  const FilterCounts counts = session.counts(filter);
  figures["steps"] = counts.steps;
  if (counts.input_gaps > 0) figures["input_gaps"] = counts.input_gaps;
  figures["filter_s"] = counts.seconds;
  if (!session.healthy(filter)) figures["broken"] = session.diagnosis(filter);
  return figures;
}

}  // namespace binnacle::score
