// SPDX-License-Identifier: Apache-2.0
// tune: parameters of a config by what its data say of them.
#include <chrono>
#include <memory>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "interrupt.hpp"
#include "output.hpp"
#include "sentinel.hpp"
#include "study/workers.hpp"
#include "tune/tune.hpp"
#include "tune_text.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct TuneVerbOptions {
  std::string config_path;
  ConfigOptions config;
  tune::TuneOptions tune;
  int jobs = 0;  // 0: all processors
  std::string write, summary;
  bool json = false, quiet = false, force = false;
};

std::string worse_text(const Json& result) {
  const Json& likelihood = result.at("judged").at("used").at("likelihood");
  return fmt::format(
      "the tuned values lower the ln likelihood of the {:.0f} rows that both accept from {:.1f} to {:.1f}: "
      "no patch was written (--force writes it)",
      likelihood.at("rows").get<double>(), likelihood.at("start").get<double>(), likelihood.at("end").get<double>());
}

int tune_config(const TuneVerbOptions& options) {
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
  if (!options.quiet && stderr_is_terminal()) tuning.on_round = [](const std::string& line) { to_stderr(line); };
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
  const bool is_worse = result.at("lowered").get<bool>() && !options.force;
  if (patch && !result.at("patch").empty() && !is_worse) {
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
    print(tune_text(result, plan));
  if (!options.quiet)
    for (const auto& note : result.at("notes")) print_note(note.get<std::string>());
  for (const auto& open : result.at("undetermined"))
    print_error("not determined and not changed: " + open.at("text").get<std::string>());
  if (is_worse) print_error(worse_text(result));
  return result.at("undetermined").empty() && result.at("converged").get<bool>() && !is_worse ? ok : failed;
}

}  // namespace

Verb tune_verb(CLI::App& command) {
  const auto options = std::make_shared<TuneVerbOptions>();
  CLI::App* app = add_verb(command, "tune");
  app->add_option("CONFIG", options->config_path, "Config with the section \"tune\"")->required();
  options->config.add_to(*app);
  app->add_option("--write", options->write, "Write the values as a merge patch for \"extends\"")
      ->type_name("FILE.json");
  app->add_option("--summary", options->summary, "Write all figures as JSON to a file")->type_name("FILE.json");
  app->add_option("--seed", options->tune.seed, "Seed of all random numbers")->type_name("N")->capture_default_str();
  app->add_option("--run", options->tune.run, "Number of the run with this seed")
      ->type_name("K")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
  app->add_option("--jobs", options->jobs, "Number of parallel runs; default: the number of processors")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  app->add_flag("--force", options->force, "Write the values even if they lower the likelihood");
  app->add_flag("--json", options->json, "Print the figures as JSON on stdout");
  app->add_flag("--quiet", options->quiet, "Print only errors: no tables or notes");
  return {app, [options] { return tune_config(*options); }};
}

}  // namespace binnacle::command
