// SPDX-License-Identifier: Apache-2.0
// report: what a run or a study left in a folder, as one HTML page.
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "output.hpp"
#include "report_file.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct Options {
  std::string folder;
  std::string output;
  bool json = false;
};

int report(const Options& options) {
  const std::filesystem::path page =
      options.output.empty() ? report_in(options.folder) : std::filesystem::path(options.output);
  const auto bytes = write_report(options.folder, page);
  if (options.json)
    print_json({{"page", page.string()}, {"bytes", bytes}});
  else if (page != "/dev/stdout")
    print(fmt::format("{}, {:.1f} MB; open it in a browser\n", page.string(), static_cast<double>(bytes) / 1e6));
  return ok;
}

}  // namespace

Verb report_verb(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  CLI::App* app = command.add_subcommand("report", "The results of run or study --out as one HTML page");
  app->add_option("DIR", options->folder, "The folder that was given to --out")->required();
  app->add_option("--output", options->output, "Write the page there instead of DIR/report.html")
      ->type_name("FILE.html");
  app->add_flag("--json", options->json, "Where the page is, and its size, as JSON on stdout");
  return {app, [options] { return report(*options); }};
}

}  // namespace binnacle::command
