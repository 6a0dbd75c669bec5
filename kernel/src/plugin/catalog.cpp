// SPDX-License-Identifier: Apache-2.0
// The catalog: where plugins are searched, and how a type's name finds its component.
#include "binnacle/catalog.hpp"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/runtime_symbol_info.hpp>

#include "base/text.hpp"
#include "plugin/library.hpp"

namespace binnacle {

using namespace internal;
namespace fs = std::filesystem;

const char* role_name(Role role) {
  constexpr const char* names[] = {"state block",     "process model", "measurement model", "derived block",
                                   "noise estimator", "source",        "transform",         "sink"};
  static_assert(std::size(names) == std::size(all_roles));
  return names[static_cast<std::size_t>(role)];
}

std::vector<std::string> exported_symbols(const fs::path& file) { return plugin::inspect_library(file).exported; }

namespace {

/// The first error, and how many more there are.
std::string in_a_line(const Diagnostics& diagnostics) {
  const auto& items = diagnostics.items();
  const std::string first = std::ranges::find(items, Severity::error, &Diagnostic::severity)->message;
  const auto more = std::ranges::count(items, Severity::error, &Diagnostic::severity) - 1;
  return more > 0 ? first + " (and " + std::to_string(more) + " more)" : first;
}

}  // namespace

void Catalog::load(const fs::path& file, Diagnostics& diagnostics) {
  std::error_code error;
  fs::path canonical = fs::canonical(file, error);
  if (error) canonical = fs::absolute(file);
  take(canonical, Loading::at_once, diagnostics);
}

void Catalog::take(const fs::path& file, Loading loading, Diagnostics& diagnostics) {
  if (!seen_.insert(file).second) {
    // What was only seen in a folder may be named as well.
    if (loading == Loading::at_once)
      load_waiting_that([&](const PluginInfo& plugin) { return plugin.file == file; }, diagnostics);
    return;
  }
  const auto plugin = plugin::examine_plugin(file, {&plugins_, &waiting_}, diagnostics);
  if (!plugin) return;
  if (loading == Loading::when_wanted && !plugin->listed.empty())
    waiting_.push_back(*plugin);
  else
    plugin::load_plugin(*plugin, plugins_, components_, diagnostics);
}

void Catalog::add(std::shared_ptr<const LinkedPlugin> plugin, Diagnostics& diagnostics) {
  load_waiting_that([&](const PluginInfo& waiting) { return waiting.name == plugin->name; }, diagnostics);
  plugin::link_plugin(std::move(plugin), plugins_, components_, diagnostics);
}

void Catalog::load_folder(const fs::path& folder, Loading loading, Diagnostics& diagnostics) {
  std::vector<std::pair<fs::path, fs::path>> files;  // as it is named, canonical
  std::error_code error;
  const fs::path canonical_folder = fs::canonical(folder, error);
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& file = entry->path();
    if (file.extension() != ".so") continue;
    std::error_code ignored;
    // Each link of a path is a call of the system: only where there may be one.
    fs::path canonical = entry->is_symlink(ignored) ? fs::canonical(file, ignored) : canonical_folder / file.filename();
    files.emplace_back(file, ignored ? fs::absolute(file) : std::move(canonical));
  }
  // So that messages come in the same order everywhere; as texts, since a path is compared part by part.
  std::ranges::sort(files, {}, [](const auto& file) -> const std::string& { return file.first.native(); });
  for (const auto& [file, canonical] : files) {
    Diagnostics found;
    take(canonical, loading, found);
    note(file, found, diagnostics);
  }
}

void Catalog::note(const fs::path& file, const Diagnostics& found, Diagnostics& diagnostics) {
  if (!found.has_errors()) return diagnostics.merge(found);
  passed_over_.emplace_back(file, in_a_line(found));
  diagnostics.warning("B047", {file.string(), 0, 0}, "", "not loaded: " + passed_over_.back().second);
}

template <class Predicate>
void Catalog::load_waiting_that(const Predicate& is_wanted, Diagnostics& diagnostics) {
  // Not std::ranges': clang 14 cannot compile the subrange of the library of g++ 12.
  const auto first =
      std::stable_partition(waiting_.begin(), waiting_.end(), [&](const auto& plugin) { return !is_wanted(plugin); });
  const std::vector<PluginInfo> wanted(first, waiting_.end());
  waiting_.erase(first, waiting_.end());
  for (const PluginInfo& plugin : wanted) {
    Diagnostics found;
    plugin::load_plugin(plugin, plugins_, components_, found);
    note(plugin.file, found, diagnostics);
  }
}

void Catalog::load_waiting(Diagnostics& diagnostics) {
  load_waiting_that([](const PluginInfo&) { return true; }, diagnostics);
}

void Catalog::load_search_path(const std::vector<PluginPath>& from_config, Diagnostics& diagnostics,
                               const std::vector<fs::path>& more_folders, Loading loading) {
  std::error_code error;
  for (const auto& [path, origin, pointer] : from_config) {
    if (fs::is_directory(path, error))
      load_folder(path, loading, diagnostics);
    else if (fs::exists(path, error))
      load(path, diagnostics);
    else
      diagnostics.error("B040", origin, pointer, "there is no plugin file or folder '" + path.string() + "'");
  }
  const char* named = std::getenv("BINNACLE_PLUGIN_PATH");
  std::istringstream folders(named ? named : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty()) continue;
    if (!fs::is_directory(folder, error))
      diagnostics.warning("B040", {}, "", "BINNACLE_PLUGIN_PATH: there is no folder '" + folder + "'");
    load_folder(folder, loading, diagnostics);
  }
  for (const auto& folder : more_folders) load_folder(folder, loading, diagnostics);
  if (!more_folders.empty()) return;  // the program may be an interpreter, beside which another installation lies
  const auto load_beside = [&](const fs::path& binary) {
    load_folder((binary.parent_path() / ".." / "lib" / "binnacle").lexically_normal(), loading, diagnostics);
  };
  const fs::path program = boost::dll::program_location(error);
  if (!error) load_beside(program);
  // The kernel may be in a shared library; a relative name would be looked up in whatever folder is the working one now.
  const fs::path own = boost::dll::symbol_location(role_name, error);
  if (own.is_absolute() && !fs::equivalent(own, program, error) && !error) load_beside(own);
}

namespace {

using base::in_quotes;
using base::joined;

std::string article(const std::string& noun) {
  return (std::string_view("aeiou").find(noun.front()) != std::string_view::npos ? "an " : "a ") + noun;
}

/// Of the plugin in a library that is not loaded, where its guard can be read.
std::string name_in(const fs::path& file) {
  const plugin::LibraryFile library = plugin::inspect_library(file);
  return library.guard ? abi::text_of(library.guard->name) : "";
}

}  // namespace

const ComponentType* Catalog::find(Role role, std::string_view name) const {
  Diagnostics ignored;
  return find(role, name, {}, "", ignored);
}

const ComponentType* Catalog::find(Role role, std::string_view name, const Origin& origin, const std::string& pointer,
                                   Diagnostics& diagnostics) const {
  const auto report = [&](const char* code, const std::string& message) {
    diagnostics.error(code, origin, pointer, message);
    return nullptr;
  };
  const std::string plugin(name.substr(0, name.find('/') == name.npos ? 0 : name.find('/')));
  const ComponentType *found = nullptr, *renamed = nullptr, *elsewhere = nullptr, *of_its_own = nullptr;
  std::vector<std::string> fitting, known;
  for (const ComponentType& type : components_) {
    const bool is_called = type.spec.type == name || type.full_name() == name;
    if (is_called && type.role != role) elsewhere = &type;
    if (type.role != role) continue;
    known.push_back(plugin.empty() ? type.spec.type : type.full_name());
    const auto& former = type.spec.former_names;
    if (!renamed && std::ranges::find(former, name) != former.end()) renamed = &type;
    if (!is_called) continue;
    found = &type;
    if (type.plugin == type.spec.type) of_its_own = &type;
    fitting.push_back(in_quotes(type.full_name()));
  }
  if (fitting.size() == 1) return found;
  if (of_its_own) return of_its_own;
  std::ranges::sort(fitting);
  if (found) return report("B022", in_quotes(name) + " is ambiguous; write " + joined(fitting, " or "));
  if (renamed) return report("B011", in_quotes(name) + " is now called " + in_quotes(renamed->full_name()));
  const std::string wanted = role_name(role);
  if (elsewhere)
    return report("B011", in_quotes(name) + " is " + article(role_name(elsewhere->role)) + ", not " + article(wanted));
  std::ranges::sort(known);  // whichever was loaded first
  const std::string near = closest(name, known);
  const std::string unknown = "unknown " + wanted + " " + in_quotes(name) + "; ";
  const std::string meant = near.empty() ? "" : "did you mean " + in_quotes(near) + "?";
  // What a library brings is known once it is loaded; its name is known before.
  bool may_be_there = false;
  for (const auto& [file, why] : passed_over_) {
    const std::string its_name = name_in(file);
    if (!plugin.empty() && !its_name.empty() && its_name != plugin) continue;
    may_be_there = true;
    report("B047", unknown + in_quotes(file.string()) + " may have it, but is not loaded: " + why +
                       (meant.empty() ? "" : "; " + meant));
  }
  if (may_be_there) return nullptr;
  const std::string names = joined(base::names_of(plugins()), ", ");
  const std::string none = names.empty() ? "no plugin is loaded" : "none of the loaded plugins has it: " + names;
  return report("B011", unknown + (meant.empty() ? none : meant));
}

const ComponentType* Catalog::want(Role role, std::string_view name, const Origin& origin, const std::string& pointer,
                                   Diagnostics& diagnostics) {
  const auto slash = name.find('/');
  load_waiting_that(
      [&](const PluginInfo& plugin) {
        if (slash != name.npos && plugin.name != name.substr(0, slash)) return false;
        return std::ranges::find(plugin.listed, name.substr(slash == name.npos ? 0 : slash + 1)) != plugin.listed.end();
      },
      diagnostics);
  if (const ComponentType* type = find(role, name)) return type;
  load_waiting(diagnostics);
  return find(role, name, origin, pointer, diagnostics);
}

std::vector<const ComponentType*> Catalog::types() const {
  std::vector<const ComponentType*> types;
  for (const ComponentType& type : components_) types.push_back(&type);
  std::ranges::sort(types, {},
                    [](const ComponentType* type) { return std::tie(type->role, type->plugin, type->spec.type); });
  return types;
}

std::vector<PluginInfo> Catalog::plugins() const {
  std::vector<PluginInfo> plugins = plugins_;
  plugins.insert(plugins.end(), waiting_.begin(), waiting_.end());
  std::ranges::sort(plugins, {}, &PluginInfo::name);
  return plugins;
}

}  // namespace binnacle
