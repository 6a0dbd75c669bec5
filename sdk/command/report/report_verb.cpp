// SPDX-License-Identifier: Apache-2.0
// report: what a run or a study left in a folder, as one HTML page; what several runs left, on one page.
#include <algorithm>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "output.hpp"
#include "report/comparison.hpp"
#include "report_file.hpp"
#include "results_folder.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

struct ReportVerbOptions {
  std::vector<std::string> folders, pairs;
  std::string output;
  bool json = false;
};

void print_page(const fs::path& page, std::size_t bytes) {
  print(fmt::format("{}, {:.1f} MB; open it in a browser\n", page.string(), static_cast<double>(bytes) / 1e6));
}

int report_one(const ReportVerbOptions& options) {
  if (!options.pairs.empty()) throw UsageError("--pair matches filters of several runs; one folder was given");
  const std::string& folder = options.folders.front();
  const fs::path page = options.output.empty() ? report_in(folder) : fs::path(options.output);
  const auto bytes = write_page(report_page(folder), page);
  if (options.json)
    print_json({{"page", page.string()}, {"bytes", bytes}});
  else if (page != "/dev/stdout")
    print_page(page, bytes);
  return ok;
}

// ---- several

/// The folder's own name; where several have it, the path as it was typed, and a number where that is typed twice.
std::vector<std::string> names_of(const std::vector<std::string>& folders) {
  std::vector<std::string> own, names;
  for (const auto& folder : folders) {
    const fs::path path = fs::path(folder).lexically_normal();
    own.push_back((path.has_filename() ? path : path.parent_path()).filename().string());
  }
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const bool is_one =
        std::count(own.begin(), own.end(), own[i]) == 1 && !own[i].empty() && own[i] != "." && own[i] != "..";
    const std::string name = is_one ? own[i] : folders[i];
    std::string unique = name;
    for (int n = 2; std::find(names.begin(), names.end(), unique) != names.end(); ++n)
      unique = fmt::format("{} ({})", name, n);
    names.push_back(unique);
  }
  return names;
}

std::vector<report::FilterPair> pairs_of(const std::vector<std::string>& texts) {
  std::vector<report::FilterPair> pairs;
  for (const auto& text : texts) {
    const auto at = text.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == text.size())
      throw UsageError(fmt::format("--pair takes FIRST=OTHER, names of filters; found '{}'", text));
    pairs.push_back({text.substr(0, at), text.substr(at + 1)});
  }
  return pairs;
}

/// Of the errors' rms and of NEES and NIS, what differs; the page and the JSON have all.
std::string differences_text(const Json& comparison) {
  Table table("l" + std::string(2 * comparison["runs"].size() - 1, 'r') + "l");
  std::vector<std::string> head{""};
  for (const auto& run : comparison["runs"]) head.push_back(run["name"]);
  for (std::size_t i = 1; i < comparison["runs"].size(); ++i) head.push_back("difference");
  table.row(head);
  const auto cell = [](const Json& value) { return figure(value.is_number() ? value.get<double>() : std::nan("")); };
  for (const auto& metric : comparison["metrics"]) {
    const std::string name = metric["name"];
    if (!name.ends_with("/rms") && !name.ends_with("/nees_mean") && !name.ends_with("/nis_mean")) continue;
    if (name.find("/windows/") != std::string::npos) continue;
    std::vector<std::string> cells{name};
    for (const auto& value : metric["values"]) cells.push_back(cell(value));
    for (std::size_t i = 1; i < metric["differences"].size(); ++i) cells.push_back(cell(metric["differences"][i]));
    cells.push_back(metric["unit"] == "1" ? "" : metric["unit"].get<std::string>());
    table.row(cells);
  }
  for (const auto& verdict : comparison["verdicts"]) {
    std::vector<std::string> cells{verdict["filter"].get<std::string>() + ": verdict"};
    for (const auto& state : verdict["states"]) cells.push_back(state.is_string() ? state.get<std::string>() : "-");
    table.row(cells);
  }
  return table.text();
}

int report_several(const ReportVerbOptions& options) {
  const auto names = names_of(options.folders);
  std::vector<report::NamedRun> runs;
  for (std::size_t i = 0; i < options.folders.size(); ++i)
    runs.push_back({names[i], options.folders[i], read_run(options.folders[i])});
  const auto pairs = pairs_of(options.pairs);
  const auto comparison = [&] {
    try {
      return report::Comparison(runs, pairs);
    } catch (const std::invalid_argument& wrong) {
      throw UsageError(wrong.what());
    }
  }();
  const fs::path page = options.output.empty() ? fs::path("comparison.html") : fs::path(options.output);
  const auto bytes = write_page(comparison.page(), page);
  if (options.json) {
    Json json{{"page", page.string()}, {"bytes", bytes}};
    json.update(comparison.json());
    print_json(json);
    return ok;
  }
  if (page == "/dev/stdout") return ok;
  print(differences_text(comparison.json()));
  print(fmt::format("{} of the configs; ", counted(comparison.json()["config"].size(), "difference")));
  print_page(page, bytes);
  flush_stdout();
  for (const auto& lack : comparison.json()["lacks"]) print_note(lack.get<std::string>());
  return ok;
}

}  // namespace

Verb report_verb(CLI::App& command) {
  const auto options = std::make_shared<ReportVerbOptions>();
  CLI::App* app = add_verb(command, "report");
  app->add_option("DIR", options->folders, "Folder of --out; several folders: their runs on one page")->required();
  app->add_option("--output", options->output,
                  "Output file, instead of DIR/report.html, or comparison.html for several folders")
      ->type_name("FILE.html");
  app->add_option("--pair", options->pairs,
                  "Several folders: filter FIRST of the first run corresponds to OTHER of the others")
      ->type_name("FIRST=OTHER")
      ->allow_extra_args(false);
  app->add_flag(
      "--json", options->json,
      "Print the file name and size of the page as JSON on stdout; for several folders, also the differences");
  return {app, [options] { return options->folders.size() == 1 ? report_one(*options) : report_several(*options); }};
}

}  // namespace binnacle::command
