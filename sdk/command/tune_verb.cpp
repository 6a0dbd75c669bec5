// SPDX-License-Identifier: Apache-2.0
// tune: parameters of a config by what its data say of them.
#include <chrono>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "interrupt.hpp"
#include "output.hpp"
#include "sentinel.hpp"
#include "study/workers.hpp"
#include "table.hpp"
#include "tune/tune.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct Options {
  std::string config_path;
  ConfigOptions config;
  tune::TuneOptions tune;
  int jobs = 0;  // 0: all processors
  std::string write, summary;
  bool json = false, quiet = false;
};

std::string shown(const Json& value) {
  if (value.is_number()) return figure(value.get<double>());
  if (!value.is_string()) return "-";
  const auto text = value.get<std::string>();
  std::size_t end = 0;
  const double number = std::stod(text, &end);
  return figure(number) + text.substr(end);
}

std::string error_of(const Json& parameter) {
  if (!parameter.contains("standard_error")) return "-";
  const double error = parameter.at("standard_error").get<double>();
  return parameter.at("relative").get<bool>() ? fmt::format("{:.1f} %", 100 * error) : figure(error);
}

std::string parameters_text(const Json& result) {
  Table table("lrrrrl");
  table.row({"parameter", "start", "end", "standard error", "evidence", ""});
  for (const auto& parameter : result.at("parameters"))
    table.row({parameter.at("name").get<std::string>(), shown(parameter.at("start")),
               shown(parameter.value("end", Json())), error_of(parameter), shown(parameter.value("evidence", Json())),
               parameter.at("state").get<std::string>()});
  return table.text();
}

/// Likelihood, NIS per row and withheld samples, at the start and at the end.
std::string judged_text(const std::string& name, const Json& judged) {
  if (judged.contains("failure")) return fmt::format("{}: {}\n", name, judged.at("failure").get<std::string>());
  const Json& likelihood = judged.at("likelihood");
  Table table("lrr");
  table.row({name, "start", "end"});
  table.row({fmt::format("ln likelihood of {:.0f} rows that both accept", likelihood.at("rows").get<double>()),
             fmt::format("{:.1f}", likelihood.at("start").get<double>()),
             fmt::format("{:.1f}", likelihood.at("end").get<double>())});
  table.row({"rows accepted", fmt::format("{:.0f}", likelihood.at("rows_start").get<double>()),
             fmt::format("{:.0f}", likelihood.at("rows_end").get<double>())});
  for (const auto& [measurement, ends] : judged.at("measurements").items()) {
    const Json start = ends.value("start", Json::object()), end = ends.value("end", Json::object());
    table.row({measurement + ": NIS per row", shown(start.value("nis_per_row", Json())),
               shown(end.value("nis_per_row", Json()))});
    if (!start.contains("withheld") || !end.contains("withheld")) continue;
    const Json &before = start.at("withheld"), &after = end.at("withheld");
    table.row(
        {measurement + ": withheld, -ln p per row", shown(before.at("nll_per_row")), shown(after.at("nll_per_row"))});
    for (const auto& [group, rms] : before.at("rms").items())
      if (after.at("rms").contains(group))
        table.row({fmt::format("{}: withheld, RMS of {} [{}]", measurement, group, rms.at("unit").get<std::string>()),
                   shown(rms.at("value")), shown(after.at("rms").at(group).at("value"))});
  }
  return table.text();
}

std::string text_of(const Json& result, const tune::Plan& plan) {
  std::string text = plan.title.empty() ? "" : plan.title + "\n\n";
  text += parameters_text(result) + "\n";
  for (const auto& open : result.at("undetermined"))
    text += "  not determined: " + open.at("text").get<std::string>() + "\n";
  if (!result.at("undetermined").empty()) text += "\n";
  text += fmt::format("  {}, {} evaluations, {} rounds, {} runs\n\n", result.at("objective").get<std::string>(),
                      result.at("evaluations").get<int>(), result.at("rounds").size(), result.at("runs").get<int>());
  const Json& judged = result.at("judged");
  text += judged_text("used", judged.at("used")) + "\n";
  if (judged.contains("unseen"))
    for (const auto& [name, part] : judged.at("unseen").items()) text += judged_text("unseen: " + name, part) + "\n";
  return text;
}

int tune_config(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  watch_signals("nothing was written");
  const tune::Plan plan = tune::read_plan(options.config_path, options.config.load_options());
  std::unique_ptr<AtomicFile> patch, summary;
  if (!options.write.empty()) patch = std::make_unique<AtomicFile>(options.write);
  if (!options.summary.empty()) summary = std::make_unique<AtomicFile>(options.summary);
  watch_exit();
  tune::TuneOptions tuning = options.tune;
  tuning.jobs = options.jobs > 0 ? options.jobs : study::processors();
  tuning.goes_on = [] { return interrupted_by() == 0; };
  if (!options.quiet && stderr_is_terminal())
    tuning.on_round = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  Json result;
  try {
    result = tune::tune(plan, tuning);
  } catch (const tune::Interrupted&) {
  }
  stand_down();
  if (interrupted_by() != 0) {
    patch.reset();
    summary.reset();
    print_error("interrupted; nothing was written");
    die_of_signal();
  }
  result["wall_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (patch && !result.at("patch").empty()) {
    patch->write(result.at("patch").dump(2) + "\n");
    patch->commit();
  }
  if (summary) {
    summary->write(result.dump(2) + "\n");
    summary->commit();
  }
  if (options.json)
    print_json(result);
  else if (!options.quiet)
    print(text_of(result, plan));
  if (!options.quiet)
    for (const auto& note : result.at("notes")) fmt::print(stderr, "note: {}\n", note.get<std::string>());
  for (const auto& open : result.at("undetermined"))
    print_error("not determined, and left as it is: " + open.at("text").get<std::string>());
  return result.at("undetermined").empty() && result.at("converged").get<bool>() ? ok : failed;
}

}  // namespace

Verb tune_verb(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  CLI::App* app = command.add_subcommand("tune", "Noise and other parameters by what the data say of them");
  app->add_option("CONFIG", options->config_path, "The config, with its \"tune\"")->required();
  options->config.add_to(*app);
  app->add_option("--write", options->write, "Write the values as a merge patch, which \"extends\" takes")
      ->type_name("FILE.json");
  app->add_option("--summary", options->summary, "Write all figures as JSON")->type_name("FILE.json");
  app->add_option("--seed", options->tune.seed, "Seed of everything random")->type_name("N")->capture_default_str();
  app->add_option("--run", options->tune.run, "Which run of the seed")
      ->type_name("K")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
  app->add_option("--jobs", options->jobs, "Runs at one time; as many as there are processors")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  app->add_flag("--json", options->json, "The figures as JSON on stdout");
  app->add_flag("--quiet", options->quiet, "Errors only: no tables or notes");
  return {app, [options] { return tune_config(*options); }};
}

}  // namespace binnacle::command
