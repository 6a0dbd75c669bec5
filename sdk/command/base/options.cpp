// SPDX-License-Identifier: Apache-2.0
// What several verbs share: --var, --set, --variant, and the plugins where there is no config.
#include <cstdlib>

#include <fmt/format.h>

#include "binnacle/unit.hpp"
#include "output.hpp"
#include "study/variants.hpp"
#include "verbs.hpp"

namespace binnacle::command {

void ConfigOptions::add_to(CLI::App& app) {
  app.add_option("--var", vars_, "Value of a variable of the config; a relative path starts at the working folder")
      ->type_name("NAME=PATH")
      ->allow_extra_args(false);
  app.add_option("--set", sets_, "Replace a value of the config at a JSON pointer; VALUE is JSON, otherwise text")
      ->type_name("PTR=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--allow-plugins", allows_plugins_,
               "Load the plugins that the config's \"plugins\" names from any folder: this runs their code");
}

LoadOptions ConfigOptions::load_options() const {
  LoadOptions options;
  for (const auto& text : vars_) {
    const auto at = text.find('=');
    if (at == std::string::npos || at == 0) throw UsageError(fmt::format("--var takes NAME=PATH; found '{}'", text));
    options.vars[text.substr(0, at)] = text.substr(at + 1);
  }
  options.sets = sets_;
  if (allows_plugins_) ::setenv("BINNACLE_ALLOW_PLUGINS", "1", 1);  // for all that this process composes
  return options;
}

void ConfigOptions::add_variant_to(CLI::App& app) {
  app.add_option("--variant", variant_, "Use one variant of the config's study")->type_name("NAME");
}

LoadOptions ConfigOptions::load_options(const std::string& config) const {
  LoadOptions options = load_options();
  if (!variant_.empty()) options.patches = study::patches_of(config, options, variant_);
  return options;
}

std::string ConfigOptions::as_typed() const {
  std::string text;
  if (!variant_.empty()) text += " --variant " + shell_quoted(variant_);
  for (const auto& var : vars_) text += " --var " + shell_quoted(var);
  for (const auto& set : sets_) text += " --set " + shell_quoted(set);
  return allows_plugins_ ? text + " --allow-plugins" : text;
}

bool is_config(const std::string& file) { return file.ends_with(".json"); }

std::string shell_quoted(const std::string& text) {
  if (!text.empty() && text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=") ==
                           std::string::npos)
    return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

Catalog load_catalog(int& status) {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load_search_path({}, diagnostics);
  print_diagnostics(diagnostics);
  status = diagnostics.has_errors() ? load : ok;
  return catalog;
}

double quantity(const std::string& option, const std::string& text, const std::string& unit) {
  const auto parsed = parse_quantity(text);
  const bool is_plain = parsed && parsed->dimension.is_dimensionless();
  if (!parsed || (!is_plain && !(parsed->dimension == parse_unit(unit)->dimension)))
    throw UsageError(fmt::format("{} takes a quantity in {}; found '{}'", option, unit, text));
  return parsed->value;
}

}  // namespace binnacle::command
