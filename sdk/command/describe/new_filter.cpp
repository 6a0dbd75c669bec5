// SPDX-License-Identifier: Apache-2.0
#include "new_filter.hpp"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "gallery.hpp"
#include "new_files.hpp"
#include "output.hpp"
#include "table.hpp"

namespace binnacle::command {

namespace fs = std::filesystem;

namespace {

bool is_allowed(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

/// "my-filter.json" of "my-filter" and of itself.
std::string file_name(const std::string& name) {
  const std::string suffix = ".json";
  const bool has_suffix = name.size() > suffix.size() && name.ends_with(suffix);
  const std::string stem = has_suffix ? name.substr(0, name.size() - suffix.size()) : name;
  if (name.find('/') != std::string::npos)
    throw UsageError(fmt::format("'{}' is not a name; --dir gives the folder", name));
  if (stem.empty() || stem.front() == '-' || !std::all_of(stem.begin(), stem.end(), is_allowed))
    throw UsageError(fmt::format("'{}' is not a name for a config (a-z, A-Z, 0-9, _, -)", name));
  return stem + suffix;
}

bool is_same(const fs::path& file, const std::string& text) {
  std::error_code error;
  return fs::is_regular_file(file, error) && contents(file) == text;
}

/// What to type next.
std::string next_steps(const std::string& config) {
  Table table("ll");
  table.row({"binnacle run " + config + " --out out", "# the errors, and out/report.html"});
  table.row({"binnacle explain " + config, "# states, models, channels"});
  table.row({"binnacle inspect YOUR_DATA.csv", "# what your own data are, before the filter reads them"});
  return "\n" + table.text();
}

}  // namespace

int make_filter(const NewFilter& wanted) {
  const std::string name = file_name(wanted.name);
  std::error_code error;
  if (!fs::is_directory(wanted.folder, error)) throw UsageError(fmt::format("there is no folder '{}'", wanted.folder));
  const fs::path folder = fs::path(wanted.folder);
  const auto at = [&](const fs::path& file) { return (folder / file).lexically_normal(); };
  const Example from = example(wanted.from);

  NewFiles files;
  std::vector<std::string> written{at(name).string()};
  files.write(at(name), contents(from.config));
  for (const fs::path& file : companions(from)) {
    if (file == name)
      throw UsageError(fmt::format("'{}' is the name of a file that {} needs; choose another", name, from.name));
    const std::string text = contents(from.config.parent_path() / file);
    if (is_same(at(file), text)) continue;  // of an earlier copy
    files.write(at(file), text);
    written.push_back(at(file).string());
  }
  files.commit();

  if (wanted.json) {
    print_json({{"config", written.front()}, {"from", from.name}, {"title", from.title}, {"files", written}});
    return ok;
  }
  std::string text = fmt::format("{}: a copy of {}{}\n", written.front(), from.name,
                                 from.title.empty() ? "" : ", \"" + from.title + "\"");
  for (std::size_t i = 1; i < written.size(); ++i) text += fmt::format("{}: read by it\n", written[i]);
  print(text + next_steps(written.front()));
  return ok;
}

int list_examples(bool json) {
  const auto examples = gallery();
  if (json) {
    Json list = Json::array();
    for (const auto& one : examples)
      list.push_back({{"name", one.name}, {"title", one.title}, {"config", one.config.string()}});
    print_json({{"examples", list}});
  } else {
    print(listed(examples));
  }
  return ok;
}

}  // namespace binnacle::command
