// SPDX-License-Identifier: Apache-2.0
#include "fixture.hpp"

#include <cmath>

namespace binnacle::test {

namespace {

using results::Error;
using results::Estimate;
using results::FilterResults;
using results::Json;
using results::Updates;

double wave(std::size_t i, double period) { return std::sin(2 * M_PI * static_cast<double>(i) / period); }

void add_states(FilterResults& filter, std::size_t n) {
  Estimate lat{"position", "lat", "rad", "deg", true, {}, {}}, lon{"position", "lon", "rad", "deg", true, {}, {}};
  Estimate bias{"gyro_bias", "x", "rad/s", "", false, {}, {}};
  Error north{"position.north", "m", "m", {}, {}, {}}, east{"position.east", "m", "m", {}, {}, {}};
  Error norm{"position.horizontal", "m", "m", {}, {}, {}}, nees{"position.nees", "1", "1", {}, {}, {}};
  Error noise{"fix.position.noise", "m", "m", {}, {}, {}};
  for (std::size_t i = 0; i < n; ++i) {
    const double t = 10 + 0.1 * static_cast<double>(i),
                 turn = 2 * M_PI * static_cast<double>(i) / static_cast<double>(n);
    filter.t.push_back(t);
    lat.values.push_back(0.8 + 3e-5 * std::sin(turn));
    lon.values.push_back(0.1 + 4e-5 * std::cos(turn));
    lat.sigma.push_back(1e-7);
    lon.sigma.push_back(1.5e-7);
    bias.values.push_back(1e-6 * wave(i, 300));
    bias.sigma.push_back(5e-6);
    for (auto* error : {&north, &east, &norm, &nees, &noise}) error->t.push_back(t);
    north.values.push_back(wave(i, 90));
    east.values.push_back(0.5 * wave(i, 70));
    norm.values.push_back(std::hypot(north.values.back(), east.values.back()));
    north.sigma.push_back(0.4);
    east.sigma.push_back(0.4);
    nees.values.push_back(2 + wave(i, 40));
    noise.values.push_back(0.5 + 0.1 * wave(i, 500));
  }
  filter.estimates = {lat, lon, bias};
  filter.errors = {north, east, norm, nees, noise};
}

void add_fixes(FilterResults& filter, std::size_t n) {
  Updates updates;
  updates.measurement = "fix";
  updates.groups = {{"position", "m"}};
  for (std::size_t i = 0; i < n; i += 10) {
    const bool is_gated = i % 400 == 0, is_refused = i % 700 == 10;
    updates.t.push_back(filter.t[i]);
    updates.outcome.push_back(is_refused ? Outcome::unsupported : is_gated ? Outcome::gated : Outcome::accepted);
    updates.reason.push_back(is_refused ? "slower than <b>min_speed</b>" : is_gated ? "NIS beyond the gate" : "");
    updates.nis.push_back(is_refused ? std::nan("") : is_gated ? 60 : 2 + 1.5 * wave(i, 37));
    updates.rows.push_back(is_refused ? 0 : 2);
    for (int row = 0; row < updates.rows.back(); ++row) {
      updates.group.push_back(0);
      updates.key.push_back(row);
      updates.residual.push_back(is_gated ? 4 : wave(i, 53));
      updates.sigma.push_back(0.7);
      updates.noise.push_back(row == 0 ? 0.5 : 0.5 + 0.1 * wave(i, 500));
    }
  }
  filter.updates = {updates};
}

Json statistics(double size, const char* unit) {
  return {{"mean", size / 300}, {"rms", size},        {"p50", size * 0.7}, {"p95", size * 1.9},
          {"max", size * 2.7},  {"final", -size / 7}, {"n", 12345},        {"unit", unit}};
}

}  // namespace

results::Results run_results(const std::string& name, std::size_t samples) {
  results::RunResults run;
  run.config = {{"binnacle", 1},
                {"title", "A drive in turns"},
                {"evaluate", {{"windows", {{"outage", {"start+20 s", "50 s"}}}}}}};
  run.provenance = {{"version", "1.2.3"},
                    {"command", "binnacle run '" + name + "'"},
                    {"seed", 18446744073709551615u},
                    {"run", 0},
                    {"created", "2026-01-02T03:04:05Z"},
                    {"plugins", Json::array({{{"name", "core"}, {"version", "1"}, {"path", "core.so"}}})}};
  FilterResults filter;
  filter.name = name;
  add_states(filter, samples);
  add_fixes(filter, samples);
  const std::size_t fixes = (samples + 9) / 10;
  run.summary["filters"][name] = {{"reference",
                                   {{"position.north", statistics(0.7071, "m")},
                                    {"position.east", statistics(1.0 / 3e5, "m")},
                                    {"position.horizontal", statistics(123456.789, "m")}}},
                                  {"windows", {{"outage", {{"position.horizontal", statistics(1.25, "m")}}}}},
                                  {"consistency", {{"position", {{"nees_mean", 2.0001}, {"dof", 2}, {"n", samples}}}}},
                                  {"noise", {{"fix.position.noise", statistics(0.5, "m")}}},
                                  {"measurements",
                                   {{"fix",
                                     {{"offered", fixes},
                                      {"accepted", fixes - 20},
                                      {"gated", 15},
                                      {"unsupported", 5},
                                      {"late", 0},
                                      {"invalid", 0},
                                      {"withheld", 0},
                                      {"rejected", 0},
                                      {"before_start", 0},
                                      {"nis_mean", 2.0471},
                                      {"dof", 2.0},
                                      {"recoveries", 3}}}}},
                                  {"start_s", 10.0},
                                  {"end_s", 10 + 0.1 * static_cast<double>(samples - 1)},
                                  {"steps", samples},
                                  {"filter_s", 0.0123}};
  run.summary["warnings"] = Json::array({"imu: a gap of 2 s"});
  run.summary["seed"] = 1;
  run.summary["wall_s"] = 0.25;
  run.filters.push_back(std::move(filter));
  return {std::move(run), std::nullopt};
}

results::Results study_results() {
  constexpr std::size_t runs = 30;
  results::StudyResults study;
  study.config = {{"title", "Two filters compared"}};
  study.provenance = {{"version", "1.2.3"}, {"command", "binnacle study compare.json"}, {"seed", 1}};
  study.variants = {"plain", "adaptive <i>x2</i>"};
  study.metrics = {{"ins/attitude.yaw/final", "mil", "rad"}, {"ins/fix/nis", "1", "1"}};
  study.runs = runs;
  for (std::size_t variant = 0; variant < 2; ++variant)
    for (std::size_t metric = 0; metric < 2; ++metric)
      for (std::size_t run = 0; run < runs; ++run)
        study.values.push_back(variant == 1 && run == 7 ? std::nan("")
                               : metric == 0            ? 1e-3 * wave(run, 11)
                                                        : 2 + wave(run, 7));
  Json& figures = study.figures;
  figures = {{"runs", runs}, {"seed", 1}};
  for (const auto& name : study.variants) {
    const bool broke = name != "plain";
    Json yaw{{"rms", 3.7712}, {"mean", -0.0312}, {"std", 3.7}, {"se", 0.117},          {"se_rms", 0.0834},
             {"p50", 2.2},    {"p95", 7.7},      {"max", 8.9}, {"n", broke ? 29 : 30}, {"unit", "mil"}};
    Json nis{{"rms", 2.1},           {"mean", 2.01}, {"std", 0.2}, {"se", 0.03},
             {"se_rms", 0.03},       {"p50", 2.0},   {"p95", 2.4}, {"max", 2.9},
             {"n", broke ? 29 : 30}, {"unit", "1"},  {"dof", 2},   {"band", {1.9, 2.1}}};
    figures["variants"][name] = {{"runs", runs},
                                 {"failed", broke ? 1 : 0},
                                 {"metrics", {{"ins/attitude.yaw/final", yaw}, {"ins/fix/nis", nis}}}};
    if (broke) figures["variants"][name]["failures"] = Json::array({{{"run", 7}, {"reason", "the filter broke"}}});
  }
  figures["table"] = {{"title", "RMS azimuth error"},
                      {"rows", {"x2"}},
                      {"columns", {"plain", "better by", "no figure"}},
                      {"cells", {{3.7712, 12.5, "aliased"}}},
                      {"se", {{0.0834, 2.5, nullptr}}},
                      {"units", {{"mil", "%", ""}}},
                      {"paper", {{3.91, nullptr, nullptr}}}};
  return {std::nullopt, std::move(study)};
}

}  // namespace binnacle::test
