// SPDX-License-Identifier: Apache-2.0
// new: a plugin's folder, which builds, passes conformance and is used by a config; or a filter's config (new_filter.hpp).
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <fmt/format.h>
#include <unistd.h>

#include "atomic_file.hpp"
#include "gallery.hpp"
#include "installation.hpp"
#include "new_filter.hpp"
#include "output.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

constexpr std::array kinds{"block", "process", "measurement", "noise", "derived", "source", "transform", "sink"};

/// Names that CMake gives to targets of its own.
constexpr std::array taken_by_cmake{"all",          "clean",   "edit_cache",
                                    "help",         "install", "list_install_components",
                                    "package",      "test",    "preinstall",
                                    "rebuild",      "depend",  "package_source",
                                    "rebuild_cache"};

constexpr std::size_t longest_name = 48;  // the guard has room for 63 characters

struct NewVerbOptions {
  std::string what;
  std::string name;
  std::string kind = "process";
  std::string folder = ".";
  std::string from;
  bool lists = false;
  bool json = false;
};

bool is_snake_case(const std::string& name) {
  const auto is_lower = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto is_allowed = [&](char c) { return is_lower(c) || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && is_lower(name.front()) && name.back() != '_' &&
         std::all_of(name.begin(), name.end(), is_allowed) && name.find("__") == std::string::npos;
}

/// "MyWalk", "my-walk" -> "my_walk"; "" where nothing is left.
std::string in_snake_case(const std::string& name) {
  std::string result;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool begins_word =
        c < 0x80 && std::isupper(c) && i > 0 && std::islower(static_cast<unsigned char>(name[i - 1]));
    if ((begins_word || !std::isalnum(c) || c >= 0x80) && !result.empty() && result.back() != '_') result += '_';
    if (c < 0x80 && std::isalnum(c)) result += static_cast<char>(std::tolower(c));
  }
  while (!result.empty() && result.back() == '_') result.pop_back();
  return is_snake_case(result) ? result : "";
}

void check_kind(const NewVerbOptions& options) {
  if (std::find(kinds.begin(), kinds.end(), options.kind) != kinds.end()) return;
  const std::vector<std::string> names(kinds.begin(), kinds.end());
  const std::string near = closest(options.kind, names);
  throw UsageError(fmt::format("there is no kind '{}'{} (kinds: {})", options.kind,
                               near.empty() ? "" : "; did you mean '" + near + "'?", joined(names)));
}

void check_name(const std::string& name) {
  if (!is_snake_case(name)) {
    const std::string near = in_snake_case(name);
    throw UsageError(fmt::format("'{}' is not a name in snake_case (a-z, 0-9, _){}", name,
                                 near.empty() ? "" : "; did you mean '" + near + "'?"));
  }
  if (name.size() > longest_name)
    throw UsageError(fmt::format("the name has {} characters; {} are possible", name.size(), longest_name));
  if (std::find(taken_by_cmake.begin(), taken_by_cmake.end(), name) != taken_by_cmake.end())
    throw UsageError(fmt::format("'{}' is the name of one of CMake's own targets; choose another", name));
  int status = ok;
  const Catalog catalog = load_catalog(status);
  for (const auto& plugin : catalog.plugins())
    if (plugin.name == name)
      throw UsageError(fmt::format("there is a plugin '{0}' already; choose another name, such as 'my_{0}'", name));
  for (const auto* type : catalog.types())
    if (type->spec.type == name)
      throw UsageError(fmt::format("there is a component '{}' already; choose another name, such as 'my_{}'",
                                   type->full_name(), name));
}

/// With the plugin's name, and without our licence line: what is made of it is its author's.
std::string filled(const std::string& text, const std::string& name) {
  static const std::string mark = "@NAME@";
  std::istringstream lines(text);
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("SPDX-License-Identifier") != std::string::npos) continue;
    for (auto at = line.find(mark); at != std::string::npos; at = line.find(mark, at + name.size()))
      line.replace(at, mark.size(), name);
    result += line + "\n";
  }
  return result;
}

/// A folder that becomes the plugin's when it is whole, and vanishes otherwise.
class NewFolder {
 public:
  explicit NewFolder(const fs::path& target)
      : target_(target),
        temporary_(target.parent_path() / fmt::format(".{}.tmp-{}", target.filename().string(), getpid())) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(target_, error)))
      throw UsageError(fmt::format("'{}' exists already; nothing was written", target_.string()));
    if (!fs::create_directory(temporary_, error))
      throw UsageError(fmt::format("cannot write '{}': {}", target_.string(),
                                   error ? error.message() : temporary_.string() + " is in the way"));
  }
  ~NewFolder() {
    std::error_code ignored;
    if (!is_kept_) fs::remove_all(temporary_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  void write(const std::string& name, const std::string& text) {
    std::ofstream file(temporary_ / name, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw OutputError(fmt::format("'{}' could not be written", (target_ / name).string()));
    files_.push_back(name);
  }
  void commit() {
    std::error_code error;
    fs::rename(temporary_, target_, error);
    if (error) throw OutputError(fmt::format("'{}' could not be written: {}", target_.string(), error.message()));
    is_kept_ = true;
  }
  const std::vector<std::string>& files() const { return files_; }

 private:
  fs::path target_, temporary_;
  std::vector<std::string> files_;
  bool is_kept_ = false;
};

/// In order of their names; what is hidden only where it is ours.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// A plugin builds with an installation, for which this is not the place.
bool is_build_tree() { return fs::exists(prefix() / "CMakeCache.txt"); }

/// How CMake finds Binnacle; nothing where it looks by itself.
std::string prefix_option() {
  const std::string place = is_build_tree() ? "PREFIX" : prefix().string();
  if (place == "/usr" || place == "/usr/local") return "";
  const bool is_plain = place.find_first_of(" '\"$&;()") == std::string::npos;
  const std::string option = "-DCMAKE_PREFIX_PATH=" + place;
  return is_plain ? " " + option : " \"" + option + "\"";
}

int make_plugin(const NewVerbOptions& options) {
  check_kind(options);
  const fs::path templates = shared_folder("sdk/template", "templates");
  check_name(options.name);
  std::error_code error;
  if (!fs::is_directory(options.folder, error))
    throw UsageError(fmt::format("there is no folder '{}'", options.folder));
  const fs::path target = (fs::path(options.folder) / options.name).lexically_normal();

  NewFolder folder(target);
  for (const fs::path& part : {templates / "common", templates / options.kind})
    for (const fs::path& file : files_in(part))
      folder.write(file.filename().string(), filled(contents(file), options.name));
  folder.commit();

  if (options.json) {
    print_json({{"folder", target.string()}, {"kind", options.kind}, {"files", folder.files()}});
    return ok;
  }
  const std::string first =
      is_build_tree() ? fmt::format("  cmake --install {} --prefix PREFIX\n", prefix().string()) : "";
  print(
      fmt::format("{}: {}\n\n{}  cd {}\n  cmake -B build{} && cmake --build build\n  ctest --test-dir build\n"
                  "  binnacle run config.json\n",
                  target.string(), joined(folder.files()), first, target.string(), prefix_option()));
  return ok;
}

/// Options of one of the two are not of the other.
void check_options(const CLI::App& app, const NewVerbOptions& options) {
  const std::vector<std::string> of_filter{"--from", "--list"}, of_plugin{"--kind"};
  for (const auto& option : options.what == "filter" ? of_plugin : of_filter)
    if (app.count(option) > 0) throw UsageError(fmt::format("'new {}' has no option {}", options.what, option));
  if (options.name.empty() && !options.lists)
    throw UsageError(fmt::format("NAME is missing: binnacle new {} NAME", options.what));
}

int make(const CLI::App& app, const NewVerbOptions& options) {
  if (options.what != "plugin" && options.what != "filter") {
    const std::string near = closest(options.what, {"plugin", "filter"});
    throw UsageError(fmt::format("there is nothing new called '{}'{}", options.what,
                                 near.empty() ? " (filter, plugin)" : "; did you mean '" + near + "'?"));
  }
  check_options(app, options);
  if (options.what == "plugin") return make_plugin(options);
  if (options.lists) return list_examples(options.json);
  NewFilter filter;
  filter.name = options.name;
  if (app.count("--from") > 0) filter.from = options.from;
  filter.folder = options.folder;
  filter.json = options.json;
  return make_filter(filter);
}

}  // namespace

Verb new_verb(CLI::App& command) {
  const auto options = std::make_shared<NewVerbOptions>();
  CLI::App* app = add_verb(command, "new");
  app->add_option("WHAT", options->what, "\"filter\" or \"plugin\"")->required();
  app->add_option(
      "NAME", options->name,
      "Name. Of a filter: the config is NAME.json. Of a plugin, in snake_case: also of its folder and component");
  app->add_option("--from", options->from, "Filter: the example or config to copy [loose-ins-gnss]")
      ->type_name("EXAMPLE");
  app->add_flag("--list", options->lists, "Filter: list the examples");
  app->add_option("--kind", options->kind,
                  "Plugin: block, process, measurement, noise, derived, source, transform or sink")
      ->type_name("KIND")
      ->capture_default_str();
  app->add_option("--dir", options->folder, "Folder for the new files")->type_name("DIR")->capture_default_str();
  app->add_flag("--json", options->json, "Print the list of written files as JSON");
  return {app, [app, options] { return make(*app, *options); }};
}

}  // namespace binnacle::command
