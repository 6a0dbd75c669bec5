// SPDX-License-Identifier: Apache-2.0
#include "other_results.hpp"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

namespace binnacle::command {

namespace {

Json without_study(Json config) {
  config.erase("study");
  return config;
}

/// The study's own config, or that of one of its variants.
bool is_of_study(const Json& run, const Json& study) {
  const Json ran = without_study(run), base = without_study(study);
  if (ran == base) return true;
  const Json section = study.value("study", Json::object());
  const Json variants = section.is_object() ? section.value("variants", Json::object()) : Json();
  if (!variants.is_object()) return run.value("study", Json()) == section;
  return std::ranges::any_of(variants, [&](const Json& patch) {
    Json varied = base;
    varied.merge_patch(patch);
    return ran == varied;
  });
}

void name(const std::filesystem::path& folder, const char* what, const Json& config, const char* files) {
  const Json title = config.value("title", Json());
  print_note(fmt::format(
      "'{}' also holds a {} of another config{}, and its page shows both; remove {} there, or give another --out",
      folder.string(), what, title.is_string() ? ", '" + title.get<std::string>() + "'" : "", files));
}

}  // namespace

void name_other_study(const std::filesystem::path& folder, const Json& study, const Json& config) {
  if (!is_of_study(config, study)) name(folder, "study", study, "study.nc and study.json");
}

void name_other_run(const std::filesystem::path& folder, const Json& config) {
  std::error_code ignored;
  if (!std::filesystem::exists(folder / "run.nc", ignored)) return;
  std::ifstream file(folder / "config.json");
  const Json run = Json::parse(file, nullptr, false);
  if (run.is_object() && !is_of_study(run, config)) name(folder, "run", run, "run.nc and summary.json");
}

}  // namespace binnacle::command
