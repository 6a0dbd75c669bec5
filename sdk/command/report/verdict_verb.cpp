// SPDX-License-Identifier: Apache-2.0
// verdict: that of a recorded run, with other limits.
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "output.hpp"
#include "results_folder.hpp"
#include "score/verdict.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct VerdictOptions {
  std::string folder;
  std::vector<std::string> limits;
  bool strict = false, json = false;
};

/// The estimates of a block, by their names: "position.north".
std::vector<std::string> estimates_of(const Json& verdict, const std::string& block) {
  std::vector<std::string> names;
  const Json estimates = verdict.value("estimates", Json::object());
  for (const auto& [name, entry] : estimates.items())
    if (name.substr(0, name.rfind('.')) == block) names.push_back(name);
  return names;
}

/// Adds "position=2 m" to the limits of a filter; false where the filter has no such block.
bool add_limit(const std::string& text, const Json& verdict, score::Limits& limits) {
  const auto at = text.find('=');
  if (at == std::string::npos) throw UsageError(fmt::format("--limit takes BLOCK=QUANTITY; found '{}'", text));
  const std::string block = text.substr(0, at);
  const auto estimates = estimates_of(verdict, block);
  if (estimates.empty()) return false;
  const std::string unit = verdict.at("estimates").at(estimates.front()).at("unit");
  for (const auto& estimate : estimates)
    if (verdict.at("estimates").at(estimate).at("unit") != unit)
      throw UsageError(
          fmt::format("--limit {}: its components have no unit in common, so they keep three sigma", block));
  const double limit = limits[block] = quantity("--limit " + block, text.substr(at + 1), unit);
  if (!(limit > 0)) throw UsageError(fmt::format("--limit {} takes a quantity above 0; found '{}'", block, text));
  return true;
}

void show(const std::string& filter, const Json& verdict, const std::string& before) {
  const std::string state = verdict.at("state"),
                    changed = state == before ? "" : fmt::format(" (recorded as {})", before);
  print(fmt::format("{}: {}{}\n", filter, state, changed));
  for (const auto& [block, limit] : verdict.at("limits").items()) {
    const std::string unit = verdict.at("estimates").at(estimates_of(verdict, block).front()).at("unit");
    print(fmt::format("  limit of {}: {} {}\n", block, figure(limit), unit));
  }
  if (verdict.at("limits").empty()) print("  limit of each estimate: 3 sigma\n");
  for (const auto& [kind, list] :
       {std::pair{"reason", verdict.at("reasons")}, {"note", verdict.value("notes", Json::array())}})
    for (const auto& entry : list)
      print(
          fmt::format("  {} {}: {}\n", kind, entry.at("code").get<std::string>(), entry.at("text").get<std::string>()));
  for (const auto& row : verdict.value("unseen", Json::array()))
    print(fmt::format("  would go unseen: a bias of '{}' {} {} of up to {} {} for {} s; it moves {} by {} {}\n",
                      row.at("measurement").get<std::string>(), row.at("part").get<std::string>(),
                      row.at("rows").front().get<int>(), figure(row.at("bias")), row.at("unit").get<std::string>(),
                      figure(row.at("for_s")), row.at("estimate").get<std::string>(), figure(row.at("effect")),
                      row.at("effect_unit").get<std::string>()));
}

int judge_again(const VerdictOptions& options) {
  const results::RunResults run = read_run(options.folder);
  Json verdicts = Json::object();
  std::vector<bool> is_known(options.limits.size());
  Verdict worst = Verdict::ok;
  for (const auto& [name, filter] : run.summary.at("filters").items()) {
    if (!filter.contains("verdict")) continue;
    Json verdict = filter.at("verdict");
    score::Limits limits;
    for (std::size_t i = 0; i < options.limits.size(); ++i)
      if (add_limit(options.limits[i], verdict, limits)) is_known[i] = true;
    if (!options.limits.empty()) score::apply_limits(verdict, limits);
    worst = std::max(worst, score::verdict_of(verdict));
    verdicts[name] = std::move(verdict);
  }
  for (std::size_t i = 0; i < options.limits.size(); ++i)
    if (!is_known[i])
      throw UsageError(fmt::format("no filter of '{}' has the block of --limit {}", options.folder, options.limits[i]));
  if (options.json) print_json(verdicts);
  if (!options.json)
    for (const auto& [name, verdict] : verdicts.items())
      show(name, verdict, run.summary.at("filters").at(name).at("verdict").at("state"));
  return worst == Verdict::lost || (options.strict && worst != Verdict::ok) ? failed : ok;
}

}  // namespace

Verb verdict_verb(CLI::App& command) {
  const auto options = std::make_shared<VerdictOptions>();
  CLI::App* app = add_verb(command, "verdict");
  app->add_option("DIR", options->folder, "Folder of --out of run")->required();
  app->add_option("--limit", options->limits,
                  "Largest error of a block that does not matter, instead of the recorded limits; again for more")
      ->type_name("BLOCK=QUANTITY")
      ->allow_extra_args(false);
  app->add_flag("--strict", options->strict, "Exit with status 1 unless every verdict is ok");
  app->add_flag("--json", options->json, "Print the verdicts as JSON on stdout");
  return {app, [options] { return judge_again(*options); }};
}

}  // namespace binnacle::command
