// SPDX-License-Identifier: Apache-2.0
// What became of a filter's samples, as the summary of a run shows it.
#include "run_figures.hpp"

#include <algorithm>
#include <utility>

#include "binnacle/state_block.hpp"
#include "conservative.hpp"
#include "wording/short_number.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

namespace {

using Json = nlohmann::ordered_json;

std::string row_name(const MeasurementInfo& info, const RowFigures& row) {
  const std::string key = std::to_string(row.key);
  return info.groups.size() > 1 ? info.groups[static_cast<std::size_t>(row.group)].name + " " + key : key;
}

/// Rows that a gate by row or key took out of accepted samples: in all, and which.
Json left_out(const MeasurementInfo& info, const MeasurementCounts& counts) {
  Json by_key = Json::object();
  for (const auto& row : counts.rows) {
    if (row.left_out == 0) continue;
    Json& count = by_key[info.gate.by == "row" ? row_name(info, row) : std::to_string(row.key)];
    count = row.left_out + (count.is_null() ? 0 : count.get<std::int64_t>());
  }
  return {{"rows", counts.rows_left_out},
          {"of", counts.rows_used + counts.rows_left_out},
          {"by_key", std::move(by_key)}};
}

/// How the innovations of each row were distributed.
Json innovations(const MeasurementInfo& info, const MeasurementCounts& counts) {
  Json rows = Json::array();
  for (const auto& row : counts.rows)
    rows.push_back({{"part", info.groups[static_cast<std::size_t>(row.group)].name},
                    {"row", row.key},
                    {"used", row.used},
                    {"refused", row.refused},
                    {"mean", row.mean},
                    {"rms", row.rms},
                    {"correlation", row.correlation},
                    {"sigma", row.sigma},
                    {"fitting_sigma", row.fitting_sigma > 0 ? Json(row.fitting_sigma) : Json()},
                    {"unit", info.groups[static_cast<std::size_t>(row.group)].unit}});
  return rows;
}

/// What is odd and leaves the verdict as it is: [{ "code", "measurement", "likely", "text" }].
Json notes(const Session& session, FilterId filter) {
  const auto& info = session.composition().filters()[static_cast<std::size_t>(filter.index)];
  Json list = Json::array();
  for (std::size_t m = 0; m < info.measurements.size(); ++m) {
    const MeasurementInfo& measurement = info.measurements[m];
    const Conservative found =
        conservative(info, measurement, session.counts(MeasurementId{filter, static_cast<int>(m)}));
    if (found.likely == Likely::nothing) continue;
    list.push_back({{"code", "B128"},
                    {"measurement", measurement.name},
                    {"likely", likely_name(found.likely)},
                    {"text", found.text}});
  }
  return list;
}

/// { "position.north": …, … }: `of(row of P)`, of every estimate; nothing where `of` gives null.
template <class Of>
Json by_estimate(const FilterInfo& info, Of&& of) {
  Json all = Json::object();
  for (const auto& block : info.blocks)
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const auto& component = block.declaration->error[static_cast<std::size_t>(block.active[a])];
      Json entry = of(block.first_row + static_cast<int>(a));
      entry["unit"] = component.unit;
      all[block.name + "." + component.name] = std::move(entry);
    }
  return all;
}

/// A bias of one row of each measurement that would most likely not be found, and the estimate that it moves farthest.
Json unseen(const FilterInfo& info, const BiasEffects& effects) {
  Json list = Json::array();
  for (std::size_t m = 0; m < info.measurements.size(); ++m) {
    const BiasEffects::Row* worst = nullptr;
    for (const auto& row : effects.rows())
      if (row.measurement == static_cast<int>(m) && row.unseen > 0 &&
          (!worst || row.unseen_in_sigma > worst->unseen_in_sigma))
        worst = &row;
    if (!worst) continue;
    const auto& group = info.measurements[m].groups[static_cast<std::size_t>(worst->group)];
    Json entry{{"measurement", info.measurements[m].name},
               {"part", group.name},
               {"rows", {worst->key}},
               {"bias", worst->unseen},
               {"unit", group.unit},
               {"for_s", worst->unseen_for}};
    const Json rows = by_estimate(info, [](int at) { return Json{{"row", at}}; });
    for (const auto& [estimate, its] : rows.items())
      if (its.at("row") == worst->unseen_at)
        entry.update(Json{{"estimate", estimate}, {"effect", worst->unseen_effect}, {"effect_unit", its.at("unit")}});
    list.push_back(std::move(entry));
  }
  return list;
}

/// A reason or note, but for its text; with what its size is known by.
Json entry_of(const TrustReason& reason, const FilterInfo& info, const BiasEffects* effects, const JumpWatch* jumps) {
  Json entry;
  if (reason.verdict != Verdict::ok) entry["verdict"] = verdict_name(reason.verdict);
  if (reason.measurement >= 0) {
    const auto& measurement = info.measurements[static_cast<std::size_t>(reason.measurement)];
    entry["measurement"] = measurement.name;
    if (reason.group >= 0) {
      entry["part"] = measurement.groups[static_cast<std::size_t>(reason.group)].name;
      entry["rows"] = Json::array({reason.key});
    }
  }
  if (reason.since != no_time) entry["since_s"] = seconds(reason.since);
  if (jumps && reason.doubt == Doubt::recovered)
    for (std::size_t b = 0; b < info.blocks.size(); ++b) {
      const double jump = jumps->largest(reason.measurement, static_cast<int>(b));
      if (jump == 0 || info.blocks[b].declaration->error.front().unit != "m") continue;
      entry["significant"] = verdict_name(reason.verdict);
      entry["jumps"][info.blocks[b].name] = {{"largest", jump}, {"unit", "m"}};
    }
  const bool is_of_row = reason.doubt == Doubt::bias || reason.doubt == Doubt::correlation;
  if (!effects || (!is_of_row && reason.doubt != Doubt::nis)) return entry;
  entry["significant"] = verdict_name(reason.verdict);
  if (!is_of_row) entry["ratio"] = reason.figure;
  const auto* const row = is_of_row ? effects->find(reason.measurement, reason.group, reason.key) : nullptr;
  if (row)
    entry["effects"] = by_estimate(info, [&](int at) {
      const BiasEffects::Effect effect = effects->effect(*row, at);
      return Json{{"largest", effect.largest}, {"of_3_sigma", effect.of_3_sigma}};
    });
  return entry;
}

Json measurement_figures(const MeasurementInfo& info, const MeasurementCounts& counts) {
  static constexpr const char* names[outcome_count] = {"accepted", "gated",    "late",    "unsupported",
                                                       "invalid",  "withheld", "rejected"};
  Json figures;
  figures["offered"] = counts.offered;
  for (int o = 0; o < outcome_count; ++o) figures[names[o]] = counts.by_outcome[o];
  figures["before_start"] = counts.before_start;
  if (counts.replayed > 0) figures["replayed"] = counts.replayed;
  if (counts.replayed > 0) figures["longest_delay_s"] = seconds(counts.longest_delay);
  if (info.recovers) figures["recoveries"] = counts.recoveries;
  if (info.update.type == "iterated")
    figures["iterated"] = {{"samples", counts.iterated},
                           {"linearizations", counts.iterations},
                           {"not_converged", counts.not_converged}};
  if (info.update.type == "unscented") figures["linearized_instead"] = counts.linearized;
  if (info.gate.by == "row" || info.gate.by == "key") figures["left_out"] = left_out(info, counts);
  if (counts.nis_count > 0) {
    figures["nis_mean"] = counts.nis_mean;
    figures["dof"] = counts.dof_mean;
  } else {
    figures["nis_mean"] = nullptr;
    figures["dof"] = info.max_rows;
  }
  if (!counts.rows.empty()) figures["innovations"] = innovations(info, counts);
  if (!counts.last_reason.empty()) figures["last_reason"] = counts.last_reason;
  return figures;
}

}  // namespace

Json sized_verdict(const Session& session, FilterId filter, const BiasEffects* effects, const JumpWatch* jumps,
                   const Limits& limits) {
  const auto& info = session.composition().filters()[static_cast<std::size_t>(filter.index)];
  const Diagnostics doubts = session.doubts(filter, Verdict::ok);
  std::vector<TrustReason> reasons(doubts.items().size());
  session.reasons(filter, reasons);
  Json verdict{{"state", "ok"}, {"reasons", Json::array()}};
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    Json entry{{"code", doubts.items()[i].code}};
    entry.update(entry_of(reasons[i], info, effects, jumps));
    std::string text = doubts.items()[i].message;
    const Json jumps_of_it = entry.value("jumps", Json::object());
    for (const auto& [block, jump] : jumps_of_it.items())
      text += "; it moved " + wording::in_quotes(block) + " by " + wording::short_number(jump.at("largest")) + " m";
    entry["text"] = text;
    verdict["reasons"].push_back(std::move(entry));
  }
  if (!session.healthy(filter))
    verdict["reasons"].push_back(
        {{"code", "B080"}, {"verdict", "lost"}, {"text", "the filter broke: " + session.diagnosis(filter)}});
  if (!session.started(filter))
    verdict["reasons"].push_back({{"code", "B081"}, {"verdict", "lost"}, {"text", "the filter never started"}});
  verdict["notes"] = notes(session, filter);
  if (effects) {
    verdict["estimates"] = by_estimate(info, [&](int at) {
      return Json{{"largest_sigma", effects->largest_sigma(at)}};
    });
    if (Json all = unseen(info, *effects); !all.empty()) verdict["unseen"] = std::move(all);
  }
  apply_limits(verdict, limits);
  for (const auto& measurement : info.measurements)
    if (!measurement.is_watched) verdict["unwatched"].push_back(measurement.name);
  return verdict;
}

Diagnostics doubts(const Session& session, FilterId filter, const Json& verdict) {
  const Diagnostics all = session.doubts(filter, Verdict::ok);
  Diagnostics doubts;
  const Json& reasons = verdict.at("reasons");
  for (Diagnostic doubt : all.items()) {
    const auto said = std::ranges::find_if(reasons, [&](const Json& reason) {
      return reason.at("text").get_ref<const std::string&>().starts_with(doubt.message);
    });
    if (said == reasons.end()) continue;
    doubt.message = said->at("text");  // with its sizes
    doubts.add(doubt);
  }
  return doubts;
}

Json run_figures(const Session& session, FilterId filter) {
  return run_figures(session, filter, sized_verdict(session, filter, nullptr, nullptr, {}));
}

Json run_figures(const Session& session, FilterId filter, Json verdict) {
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
  if (counts.longest_lag > 0) figures["longest_lag_s"] = seconds(counts.longest_lag);
  figures["filter_s"] = counts.seconds;
  figures["verdict"] = std::move(verdict);
  if (!session.healthy(filter)) figures["broken"] = session.diagnosis(filter);
  return figures;
}

}  // namespace binnacle::score
