// SPDX-License-Identifier: Apache-2.0
#include "score/verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace binnacle::score {

namespace {

using Json = nlohmann::ordered_json;

/// The limit of an estimate, "position.north"; 0: 3 σ alone.
double limit_of(const std::string& estimate, const Limits& limits) {
  const auto found = limits.find(estimate.substr(0, estimate.rfind('.')));
  return found == limits.end() ? 0.0 : found->second;
}

/// False for null too, which is how a file has what is not finite.
bool is_within(const Json& value, double limit) { return value.is_number() && value.get<double>() <= limit; }

/// `effects` of a reason: what its row did to the estimates.
bool are_small(const Json& effects, const Limits& limits) {
  return std::ranges::all_of(effects.items(), [&](const auto& item) {
    return is_within(item.value().at("of_3_sigma"), 0.5) ||
           is_within(item.value().at("largest"), limit_of(item.key(), limits) / 2);
  });
}

/// As `ratio` of innovations: the errors of all estimates are taken to be √ratio times as large as σ says.
bool is_small(const Json& ratio, const Json& estimates, const Limits& limits) {
  constexpr double one_percent = 2.5758;  // σ
  return ratio.is_number() && std::ranges::all_of(estimates.items(), [&](const auto& item) {
           const double errors = one_percent * std::sqrt(ratio.get<double>());
           return errors <= 3 || is_within(item.value().at("largest_sigma"), limit_of(item.key(), limits) / errors);
         });
}

/// `jumps` of a recovery: it moved a position by more than ten times its limit.
bool is_far(const Json& jumps, const Limits& limits) {
  return std::ranges::any_of(jumps.items(), [&](const auto& item) {
    const auto limit = limits.find(item.key());
    return limit != limits.end() && !is_within(item.value().at("largest"), 10 * limit->second);
  });
}

}  // namespace

void apply_limits(Json& verdict, const Limits& limits) {
  Json all = verdict.value("notes", Json::array()), reasons = Json::array(), notes = Json::array();
  for (const auto& reason : verdict.at("reasons")) all.push_back(reason);
  for (Json& entry : all) {
    if (entry.contains("jumps")) {
      entry["verdict"] = is_far(entry.at("jumps"), limits) ? Json("lost") : entry.at("significant");
    } else if (entry.contains("significant")) {
      const bool is_without_size = entry.contains("effects")
                                       ? are_small(entry.at("effects"), limits)
                                       : is_small(entry.value("ratio", Json()), verdict.at("estimates"), limits);
      entry.erase("verdict");
      if (!is_without_size) entry["verdict"] = entry.at("significant");
    }
    (entry.contains("verdict") ? reasons : notes).push_back(std::move(entry));
  }
  Verdict worst = Verdict::ok;
  for (const auto& reason : reasons) worst = std::max(worst, verdict_of({{"state", reason.at("verdict")}}));
  verdict["state"] = verdict_name(worst);
  verdict["reasons"] = std::move(reasons);
  verdict.erase("notes");
  if (!notes.empty()) verdict["notes"] = std::move(notes);
  verdict["limits"] = limits;
}

Verdict verdict_of(const Json& verdict) {
  constexpr std::array all{Verdict::ok, Verdict::doubtful, Verdict::lost};
  const auto found = std::ranges::find(all, verdict.at("state").get<std::string>(), verdict_name);
  return found == all.end() ? Verdict::lost : *found;
}

}  // namespace binnacle::score
