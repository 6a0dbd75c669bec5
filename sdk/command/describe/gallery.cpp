// SPDX-License-Identifier: Apache-2.0
#include "gallery.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "installation.hpp"
#include "output.hpp"
#include "table.hpp"
#include "wording/wording.hpp"

namespace binnacle::command {

namespace fs = std::filesystem;

namespace {

constexpr int deepest = 100;  // levels of a config; what lies deeper is not looked at

Json parsed(const fs::path& file) {
  try {
    return Json::parse(contents(file), nullptr, true, true);
  } catch (const nlohmann::json::exception&) {
    throw UsageError(fmt::format("'{0}' is not JSON; `binnacle check {0}` shows where", file.string()));
  }
}

std::string title_of(const fs::path& file) {
  const Json config = parsed(file);
  return config.is_object() && config.contains("title") && config["title"].is_string() ? config["title"] : "";
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  bool is_in_word = false;
  for (const char c : lower(text)) {
    const bool is_letter = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (is_letter && !is_in_word) words.emplace_back();
    if (is_letter) words.back() += c;
    is_in_word = is_letter;
  }
  return words;
}

/// By its letters, or else one whose name or title has all of its words: "uwb", "gnss-tight".
std::string nearest_example(const std::string& name, const std::vector<Example>& examples) {
  const std::string spelled = closest(name, wording::names_of(examples));
  const auto words = words_of(name);
  if (!spelled.empty() || words.empty()) return spelled;
  for (const auto& one : examples) {
    const std::string text = lower(one.name + " " + one.title);
    if (std::all_of(words.begin(), words.end(), [&](const auto& word) { return text.find(word) != std::string::npos; }))
      return one.name;
  }
  return "";
}

/// Collects the files that a config names.
class Companions {
 public:
  explicit Companions(const Example& example) : example_(example), folder_(example.config.parent_path()) {}

  std::vector<fs::path> found() {
    read(example_.config.filename());
    return files_;
  }

 private:
  void read(const fs::path& file) {
    const Json config = parsed(folder_ / file);
    if (config.is_object() && config.contains("vars")) add_variables(config["vars"]);
    look_at(config, "", file.parent_path(), 0);
  }

  void add_variables(const Json& variables) {
    if (!variables.is_object()) return;
    for (const auto& [name, value] : variables.items())
      if (value.is_string()) variables_.emplace_back("${" + name + "}", value.get<std::string>());
  }

  void look_at(const Json& value, const std::string& key, const fs::path& from, int depth) {
    if (depth > deepest) return;
    if (value.is_object())
      for (const auto& [name, member] : value.items()) look_at(member, name, from, depth + 1);
    else if (value.is_array())
      for (const auto& item : value) look_at(item, key, from, depth + 1);
    else if (value.is_string())
      look_at(value.get<std::string>(), key, from);
  }

  void look_at(const std::string& text, const std::string& key, const fs::path& from) {
    const bool is_extended = key == "extends";
    const std::string name = is_extended ? text.substr(0, text.find('#')) : filled(text);
    if (name.empty() || fs::path(name).is_absolute() || name.find('\0') != std::string::npos) return;
    const fs::path file = (from / name).lexically_normal();
    std::error_code error;
    if (*file.begin() == ".." || key == "plugins" || (key == "path" && fs::is_directory(folder_ / file, error)))
      throw UsageError(
          fmt::format("'{}' needs '{}', which is not copied; run the example in its folder, or copy this folder",
                      example_.name, name));
    if (!is_extended && !fs::is_regular_file(folder_ / file, error)) return;
    if (file == example_.config.filename() || std::find(files_.begin(), files_.end(), file) != files_.end()) return;
    files_.push_back(file);
    if (is_extended) read(file);
  }

  /// With the values of variables in place of their names.
  std::string filled(std::string text) const {
    for (const auto& [mark, value] : variables_)
      if (const auto at = text.find(mark); at != std::string::npos) text.replace(at, mark.size(), value);
    return text;
  }

  const Example& example_;
  fs::path folder_;
  std::vector<fs::path> files_;
  std::vector<std::pair<std::string, std::string>> variables_;
};

}  // namespace

std::vector<Example> gallery() {
  std::vector<Example> examples;
  for (const auto& entry : fs::directory_iterator(shared_folder("configs/gallery", "examples")))
    if (entry.is_regular_file() && entry.path().extension() == ".json")
      examples.push_back({entry.path().stem().string(), title_of(entry.path()), entry.path()});
  std::sort(examples.begin(), examples.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return examples;
}

std::string listed(const std::vector<Example>& examples) {
  Table table("ll");
  for (const auto& one : examples) table.row({one.name, one.title});
  return table.text();
}

Example example(const std::string& name_or_path) {
  const auto examples = gallery();
  for (const auto& one : examples)
    if (one.name == name_or_path || one.name + ".json" == name_or_path) return one;
  std::error_code error;
  if (fs::is_regular_file(name_or_path, error))
    return {name_or_path, title_of(name_or_path), fs::absolute(name_or_path)};
  const std::string near = nearest_example(name_or_path, examples);
  std::string list = listed(examples);
  if (!list.empty()) list.pop_back();  // the last line's end
  throw UsageError(fmt::format("there is no example '{}'{}\n{}", name_or_path,
                               near.empty() ? "" : "; did you mean '" + near + "'?", list));
}

std::vector<fs::path> companions(const Example& example) { return Companions(example).found(); }

}  // namespace binnacle::command
