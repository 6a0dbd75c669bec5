// SPDX-License-Identifier: Apache-2.0
// The verbs: each adds its subcommand, and is carried out once the whole command line has been understood.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/config.hpp"

namespace binnacle::command {

struct Verb {
  CLI::App* app = nullptr;
  std::function<int()> act;  // returns the exit status
};

Verb run_verb(CLI::App& command);
Verb study_verb(CLI::App& command);
Verb covariance_verb(CLI::App& command);
Verb observe_verb(CLI::App& command);
Verb allan_verb(CLI::App& command);
Verb inspect_verb(CLI::App& command);
Verb tune_verb(CLI::App& command);
Verb check_verb(CLI::App& command);
Verb explain_verb(CLI::App& command);
Verb graph_verb(CLI::App& command);
Verb report_verb(CLI::App& command);
Verb export_verb(CLI::App& command);
Verb list_verb(CLI::App& command);
Verb describe_verb(CLI::App& command);
Verb create_verb(CLI::App& command);
Verb schema_verb(CLI::App& command);
Verb new_verb(CLI::App& command);
Verb version_verb(CLI::App& command);
Verb conform_verb(CLI::App& command);

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

/// A word of a command line, quoted where a shell wants it.
std::string shell_quoted(const std::string& text);

/// The plugins found without a config. What could not be loaded is reported on stderr; `status` is then 4.
Catalog load_catalog(int& status);

}  // namespace binnacle::command
