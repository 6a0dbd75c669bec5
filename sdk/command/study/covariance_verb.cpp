// SPDX-License-Identifier: Apache-2.0
// covariance: a composition run on covariances alone, with a truth that may differ from the filter.
#include <chrono>
#include <memory>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "covariance/analysis.hpp"
#include "covariance_text.hpp"
#include "interrupt.hpp"
#include "output.hpp"
#include "sentinel.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct CovarianceVerbOptions {
  std::string config_path;
  ConfigOptions config;
  std::string summary;
  bool json = false, quiet = false, budget = false;
};

int tell_failures(const Json& summary) {
  int failures = 0;
  for (const auto& [name, variant] : summary.at("variants").items())
    if (variant.contains("failures"))
      for (const auto& failure : variant.at("failures")) {
        print_error(fmt::format("variant '{}': {}", name, failure.at("reason").get<std::string>()));
        ++failures;
      }
  return failures;
}

int analyse(const CovarianceVerbOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  watch_signals("nothing was written");
  const LoadOptions load = options.config.load_options();
  const auto study = covariance::load(options.config_path, load);
  std::unique_ptr<AtomicFile> file;
  if (!options.summary.empty()) file = std::make_unique<AtomicFile>(options.summary);
  watch_exit();  // again, now that the plugins are loaded
  Json summary;
  try {
    summary = covariance::analyse(study, options.config_path, load, [] { return interrupted_by() == 0; });
  } catch (const covariance::Interrupted&) {
  }
  stand_down();
  if (interrupted_by() != 0) {
    file.reset();
    print_error("interrupted; nothing was written");
    die_of_signal();
  }
  summary["wall_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (file) {
    file->write(summary.dump(2) + "\n");
    file->commit();
  }
  if (!options.quiet) print_abridged(study.warnings(), "binnacle check has all");
  if (options.json) {
    print_json(summary);
  } else if (!options.quiet) {
    print(covariance_text(summary, study, options.budget));
  }
  return tell_failures(summary) == 0 ? ok : failed;
}

}  // namespace

Verb covariance_verb(CLI::App& command) {
  const auto options = std::make_shared<CovarianceVerbOptions>();
  CLI::App* app = add_verb(command, "covariance");
  app->add_option("CONFIG", options->config_path, "Config with the section \"covariance\"")->required();
  options->config.add_to(*app);
  app->add_option("--summary", options->summary, "Write the figures as JSON to a file")->type_name("FILE.json");
  app->add_flag("--budget", options->budget, "Also print the share of each error source in every final variance");
  app->add_flag("--json", options->json, "Print the figures as JSON on stdout");
  app->add_flag("--quiet", options->quiet, "Print only errors: no warnings or tables");
  return {app, [options] { return analyse(*options); }};
}

}  // namespace binnacle::command
