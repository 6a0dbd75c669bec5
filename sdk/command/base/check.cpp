// SPDX-License-Identifier: Apache-2.0
#include "check.hpp"

#include <memory>

#include "interrupt.hpp"
#include "output.hpp"

namespace binnacle::command {

namespace {

struct CheckVerbOptions {
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

/// Every error of every config, or nothing.
int check(const CheckVerbOptions& options, const WarningsOf& warnings_of, const BeforeCheck& before) {
  const LoadOptions load_options = options.config.load_options();
  if (before) before(options.configs, load_options);
  watch_signals("the check is not over");
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

Verb add_check(CLI::App& command, const WarningsOf& warnings_of, const BeforeCheck& before) {
  const auto options = std::make_shared<CheckVerbOptions>();
  CLI::App* app = add_verb(command, "check");
  app->add_option("CONFIG", options->configs, "Configs")->required();
  options->config.add_to(*app);
  app->add_flag("--json", options->json, "Print errors and warnings as a JSON array on stdout");
  app->add_flag("--quiet", options->quiet, "Print only errors, no warnings");
  return {app, [=] { return check(*options, warnings_of, before); }};
}

}  // namespace binnacle::command
