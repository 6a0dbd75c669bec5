// SPDX-License-Identifier: Apache-2.0
// check: every error of every config, or nothing.
#include "interrupt.hpp"
#include "output.hpp"
#include "verbs.hpp"
#include "warnings.hpp"

namespace binnacle::command {

namespace {

struct Options {
  std::vector<std::string> configs;
  ConfigOptions config;
  bool json = false;
  bool quiet = false;
};

/// A plugin that cannot be loaded outweighs a wrong config, and that outweighs missing data: as within one config.
int heavier(int a, int b) {
  const auto weight = [](int status) { return status == load ? 3 : status == config ? 2 : status == data ? 1 : 0; };
  return weight(b) > weight(a) ? b : a;
}

int check(const Options& options) {
  watch_signals("the check is not over");
  const LoadOptions load_options = options.config.load_options();
  Diagnostics found;
  int status = ok;
  for (const auto& path : options.configs) {
    try {
      const Diagnostics warnings = warnings_of(path, load_options);
      if (!options.quiet) found.merge(warnings);
    } catch (const Error& error) {
      found.merge(error.diagnostics());
      status = heavier(status, error.exit_status());
    }
  }
  stand_down();
  if (interrupted_by() != 0) die_of_signal();
  if (options.json)
    print_json(to_json(found));
  else
    print_diagnostics(found);
  return status;
}

}  // namespace

Verb check_verb(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  CLI::App* app = command.add_subcommand("check", "Check configs and print all errors");
  app->add_option("CONFIG", options->configs, "Configs")->required();
  options->config.add_to(*app);
  app->add_flag("--json", options->json, "Print errors and warnings as a JSON array on stdout");
  app->add_flag("--quiet", options->quiet, "Print only errors, no warnings");
  return {app, [options] { return check(*options); }};
}

}  // namespace binnacle::command
