// SPDX-License-Identifier: Apache-2.0
// The verbs: each adds its subcommand, and is carried out once the whole command line has been understood. The command is
// several programs (verb_table.hpp): what a run needs is in one of them, other verbs are in the modules beside it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/config.hpp"
#include "command_main.hpp"
#include "verb_table.hpp"

namespace binnacle::command {

struct Verb {
  CLI::App* app = nullptr;
  std::function<int()> act;  // returns the exit status
};

/// --var, --set and --allow-plugins, and --variant where one variant of a study is meant.
class ConfigOptions {
 public:
  void add_to(CLI::App& app);
  void add_variant_to(CLI::App& app);
  /// Throws UsageError where a --var is not NAME=VALUE.
  LoadOptions load_options() const;
  /// With the patches of --variant.
  LoadOptions load_options(const std::string& config) const;
  /// As they are typed in a shell: " --var data=elsewhere --set /title=Another".
  std::string as_typed() const;

 private:
  std::vector<std::string> vars_, sets_;
  std::string variant_;
  bool allows_plugins_ = false;
};

/// True if a file is taken for a config, by its name.
bool is_config(const std::string& file);

/// "47.5 m", or a number of SI; UsageError where it is neither.
double quantity(const std::string& option, const std::string& text, const std::string& unit);

/// A word of a command line, quoted where a shell wants it.
std::string shell_quoted(const std::string& text);

/// The plugins found without a config. What could not be loaded is reported on stderr; `status` is then 4.
Catalog load_catalog(int& status);

}  // namespace binnacle::command
