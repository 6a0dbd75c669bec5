// SPDX-License-Identifier: Apache-2.0
// report: what a run or a study left in a folder, as one HTML page.
#include "report/page.hpp"

#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "output.hpp"
#include "results/results.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct Options {
  std::string folder;
  std::string output;
  bool json = false;
};

results::Results read(const std::string& folder) {
  try {
    return results::read(folder);
  } catch (const std::runtime_error& error) {
    throw OutputError(error.what());
  }
}

int report(const Options& options) {
  const auto path = options.output.empty() ? std::filesystem::path(options.folder) / "report.html"
                                           : std::filesystem::path(options.output);
  const std::string page = report::page(read(options.folder));
  AtomicFile file(path);
  file.write(page);
  file.commit();
  if (options.json)
    print_json({{"page", path.string()}, {"bytes", page.size()}});
  else if (options.output != "/dev/stdout")
    print(fmt::format("{}, {:.1f} MB; open it in a browser\n", path.string(), static_cast<double>(page.size()) / 1e6));
  return ok;
}

}  // namespace

Verb report_verb(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  CLI::App* app = command.add_subcommand("report", "The results of run or study --out as one HTML page");
  app->add_option("DIR", options->folder, "The folder that was given to --out")->required();
  app->add_option("--output", options->output, "Write the page there instead of DIR/report.html")->type_name("FILE.html");
  app->add_flag("--json", options->json, "Where the page is, and its size, as JSON on stdout");
  return {app, [options] { return report(*options); }};
}

}  // namespace binnacle::command
