// SPDX-License-Identifier: Apache-2.0
// inspect: looks at data before a filter does.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "atomic_file.hpp"
#include "inspect/inspect.hpp"
#include "inspect_lever_arms.hpp"
#include "inspect_sources.hpp"
#include "inspect_text.hpp"
#include "output.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct InspectVerbOptions {
  std::vector<std::string> files;
  ConfigOptions config;
  std::string page, proposal;
  bool json = false, strict = false, force = false;
};

void write_whole(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

/// An edited config is not lost: only what the proposal equals is replaced, unless --force is given.
void write_proposal(const InspectVerbOptions& options, const std::string& text) {
  if (!options.force && std::filesystem::is_regular_file(options.proposal) && contents(options.proposal) != text)
    throw UsageError("'" + options.proposal +
                     "' exists already and differs from the proposal; it was left as it is (--force replaces it)");
  write_whole(options.proposal, text);
}

int inspect_files(const InspectVerbOptions& options) {
  auto inspection = inspect::inspect(channels_of(options.files, options.config.load_options(), [] { return true; }));
  if (is_config(options.files.front()))
    inspect::compare_lever_arms(stated_lever_arms(options.files.front(), options.config.load_options()), inspection);
  bool has_warnings = false;
  for (const auto& found : inspection.findings) has_warnings |= found.severity == inspect::Severity::warning;
  if (!options.page.empty()) {
    std::string title = "Inspection of";
    for (const auto& file : options.files) title += " " + std::filesystem::path(file).filename().string();
    write_whole(options.page, inspect::page(inspection, title));
  }
  std::string proposed;
  int status = has_warnings && options.strict ? failed : ok;
  if (!options.proposal.empty()) {
    const auto folder = std::filesystem::absolute(options.proposal).parent_path();
    const auto proposal =
        inspect::propose(inspection, folder.string(), is_config(options.files.front()) ? options.files.front() : "");
    if (proposal.config.is_null()) {
      print_error("no config can be proposed: " + proposal.reason);
      status = failed;
    } else {
      write_proposal(options, proposal.config.dump(2) + "\n");
      for (const auto& note : proposal.notes) proposed += "  " + note + "\n";
    }
  }
  if (options.json)
    print_json(inspect::to_json(inspection));
  else
    print(inspection_text(inspection) + (proposed.empty() ? "" : "\nIn " + options.proposal + "\n" + proposed));
  return status;
}

}  // namespace

Verb inspect_verb(CLI::App& command) {
  const auto options = std::make_shared<InspectVerbOptions>();
  CLI::App* app = add_verb(command, "inspect");
  app->add_option("FILE", options->files, "A config, or data files such as imu.csv gnss.csv")->required();
  options->config.add_to(*app);
  app->add_option("--page", options->page, "Write an HTML page with plots")->type_name("FILE.html");
  app->add_option("--write", options->proposal,
                  "Write a config with the remedies applied, and the lever arm if turning shows it")
      ->type_name("FILE.json");
  app->add_flag("--force", options->force, "Let --write replace a file that differs from the proposal");
  app->add_flag("--strict", options->strict, "Exit with status 1 if there is a warning");
  app->add_flag("--json", options->json, "Print the findings as JSON on stdout");
  return {app, [options] { return inspect_files(*options); }};
}

}  // namespace binnacle::command
