// SPDX-License-Identifier: Apache-2.0
// version: this program's, and what a plugin must have been built with.
#include "binnacle/version.hpp"

#include "binnacle/catalog.hpp"
#include "output.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

int show_version(bool json) {
  const auto guard = host_guard();
  if (json) {
    Json fields = Json::object();
    for (const auto& [name, value] : guard) fields[name] = value;
    print_json({{"version", BINNACLE_VERSION}, {"guard", std::move(fields)}});
    return ok;
  }
  Table table("ll");
  for (const auto& [name, value] : guard) table.row({name, value});
  print("binnacle " BINNACLE_VERSION "\nABI guard\n" + table.text());
  return ok;
}

}  // namespace

Verb version_verb(CLI::App& command) {
  const auto json = std::make_shared<bool>(false);
  CLI::App* app = add_verb(command, "version");
  app->add_flag("--json", *json, "As JSON");
  return {app, [json] { return show_version(*json); }};
}

}  // namespace binnacle::command
