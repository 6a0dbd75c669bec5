// SPDX-License-Identifier: Apache-2.0
#include "verb_table.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>
#include <unistd.h>

#include "installation.hpp"
#include "output.hpp"

namespace binnacle::command {

namespace {

// A module is named after its first verb, so that its manual page is that verb's.
constexpr std::string_view describe = "binnacle-describe", study = "binnacle-study", inspect = "binnacle-inspect",
                           report = "binnacle-report", conform = "binnacle-conform";

constexpr KnownVerb all_verbs[] = {
    {"run", "Run a config on its data and print a summary of the errors", ""},
    {"study", "Run the variants of a config many times and print tables of their errors", study},
    {"covariance", "Predict a filter's errors from covariances alone, without data", study},
    {"tune", "Estimate noise and other parameters from data", study},
    {"observe", "Observability of a run: which states its measurements determine", study},
    {"allan", "Determine the noise of a channel from its Allan deviation", study},
    {"inspect", "Inspect data before a filter uses them: units, signs, axes, clocks, mounting", inspect},
    {"check", "Check configs and print all errors", ""},
    {"explain", "Explain a composition without running it: state layout, couplings, channels", describe},
    {"list", "List the component types", describe},
    {"describe", "Describe a component type: parameters, ports, fields, source", describe},
    {"create", "Print the skeleton of a config with components of these types", describe},
    {"schema", "Print the JSON Schema (draft-07) of configs, for editors", describe},
    {"graph", "Print the composition as a graph in DOT or SVG, and the sparsity of its matrices", describe},
    {"report", "Write the results of run or study --out as one HTML page, or compare several runs", report},
    {"export", "Convert the results of run --out for maps and other programs", report},
    {"verdict", "Judge the results of run --out again, with other limits", report},
    {"new", "Create a config (`new filter NAME`), or a plugin that builds and passes its tests (`new plugin NAME`)",
     describe},
    {"conform", "Test a plugin library against the plugin contract (details: conform --help)", conform},
    {"version", "Print the version and the ABI guard", ""}};

}  // namespace

std::span<const KnownVerb> known_verbs() { return all_verbs; }

const KnownVerb* known_verb(std::string_view name) {
  const auto found = std::ranges::find(all_verbs, name, &KnownVerb::name);
  return found == std::end(all_verbs) ? nullptr : found;
}

CLI::App* add_verb(CLI::App& command, std::string_view name) {
  return command.add_subcommand(std::string(name), std::string(known_verb(name)->summary));
}

void hand_over(std::string_view module, const std::string& what, const std::vector<std::string>& words) {
  const std::filesystem::path program = program_folder() / module;
  std::vector<std::string> all = {program.string()};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (auto& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  flush_stdout();
  ::execv(program.c_str(), arguments.data());
  const int fault = errno;
  if (fault == ENOENT)
    throw UsageError(fmt::format("this build has no {} ({} is missing); in a clone, sdk/run --all builds it", what,
                                 program.string()));
  throw UsageError(fmt::format("{} cannot be run, which has {}: {}", program.string(), what, std::strerror(fault)));
}

void hand_over(const KnownVerb& verb, std::vector<std::string> words) {
  if (verb.module == conform) words.erase(words.begin());  // has one verb, and does without its name
  hand_over(verb.module, fmt::format("'{}'", verb.name), words);
}

}  // namespace binnacle::command
