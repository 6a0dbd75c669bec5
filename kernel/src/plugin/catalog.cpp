// SPDX-License-Identifier: Apache-2.0
// The catalog: where plugins are searched, and how a type's name finds its component.
#include "binnacle/catalog.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <system_error>
#include <tuple>

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

std::vector<std::string> exported_symbols(const fs::path& file) {
  return plugin::inspect_library(plugin::OpenFile(file)).exported;
}

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
  plugin::FolderLook look;
  plugin::take_plugin(file, look, loading == Loading::when_wanted, waiting_, plugins_, components_, diagnostics);
}

void Catalog::add(std::shared_ptr<const LinkedPlugin> plugin, Diagnostics& diagnostics) {
  load_waiting_that([&](const PluginInfo& waiting) { return waiting.name == plugin->name; }, diagnostics);
  plugin::link_plugin(std::move(plugin), plugins_, components_, diagnostics);
}

namespace {

/// The libraries in a folder, as they are named, and canonical.
std::vector<std::pair<fs::path, fs::path>> libraries_in(const fs::path& folder) {
  std::vector<std::pair<fs::path, fs::path>> files;
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
  return files;
}

/// Those of BINNACLE_PLUGIN_PATH.
std::vector<fs::path> folders_of_user(Diagnostics& diagnostics) {
  const auto warn = [&](const std::string& text) {
    diagnostics.warning("B040", {}, "", "BINNACLE_PLUGIN_PATH: " + text);
  };
  std::vector<fs::path> folders;
  std::error_code error;
  const char* named = std::getenv("BINNACLE_PLUGIN_PATH");
  std::istringstream list(named ? named : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    if (folder.empty()) continue;
    if (fs::path(folder).is_relative())
      warn("'" + folder + "' is not searched, because its meaning depends on the working folder; write '" +
           fs::absolute(folder).lexically_normal().string() + "'");
    else if (fs::is_directory(folder, error))
      folders.emplace_back(folder);
    else
      warn("there is no folder '" + folder + "'");
  }
  return folders;
}

/// In lib/binnacle beside the program, and beside the library that the kernel may be in.
std::vector<fs::path> folders_beside() {
  std::vector<fs::path> folders;
  const auto add_beside = [&](const fs::path& binary) {
    folders.push_back((binary.parent_path() / ".." / "lib" / "binnacle").lexically_normal());
  };
  std::error_code error;
  const fs::path program = boost::dll::program_location(error);
  if (!error) add_beside(program);
  // A relative name would be looked up in whatever folder is the working one now.
  const fs::path own = boost::dll::symbol_location(role_name, error);
  if (own.is_absolute() && !fs::equivalent(own, program, error) && !error) add_beside(own);
  return folders;
}

bool is_below(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path way = file.lexically_relative(fs::canonical(folder, error));
  return !error && !way.empty() && *way.begin() != "..";
}

/// Whether a config may have this loaded: what the command line or the program says, or what lies where plugins are searched
/// anyway, or was built here.
bool is_trusted(const PluginPath& named, const std::vector<fs::path>& folders) {
  const char* const allowed = std::getenv("BINNACLE_ALLOW_PLUGINS");
  if (named.origin.file.empty() || named.origin.file == "--set" || (allowed && *allowed)) return true;
  std::error_code error;
  const fs::path path = fs::canonical(named.path, error);
  if (std::ranges::any_of(folders, [&](const fs::path& folder) { return is_below(path, folder); })) return true;
  if (!fs::is_directory(path, error)) return plugin::is_built_here(path);
  return std::ranges::all_of(libraries_in(path), [](const auto& file) { return plugin::is_built_here(file.second); });
}

/// Unless there is more to say against it; none of its code runs.
void report_untrusted(const PluginPath& named, Diagnostics& diagnostics) {
  const auto& [path, origin, pointer] = named;
  Diagnostics found;
  std::error_code error;
  if (fs::is_directory(path, error) || plugin::examine_plugin(path, {}, found))
    diagnostics.error("B048", origin, pointer,
                      "'" + path.string() +
                          "' is not loaded: a config may only name plugins that lie in a trusted folder or were built "
                          "here; --allow-plugins loads it");
  else
    diagnostics.merge(found);
}

}  // namespace

void Catalog::load_folder(const fs::path& folder, Loading loading, Diagnostics& diagnostics) {
  plugin::FolderLook look;
  for (const auto& [file, canonical] : libraries_in(folder)) {
    Diagnostics found;
    if (!seen_.insert(canonical).second)
      take(canonical, loading, found);
    else
      plugin::take_plugin(canonical, look, loading == Loading::when_wanted, waiting_, plugins_, components_, found);
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
    plugin::load_waiting_plugin(plugin, plugins_, components_, found);
    note(plugin.file, found, diagnostics);
  }
}

void Catalog::load_waiting(Diagnostics& diagnostics) {
  load_waiting_that([](const PluginInfo&) { return true; }, diagnostics);
}

void Catalog::load_search_path(const std::vector<PluginPath>& from_config, Diagnostics& diagnostics,
                               const std::vector<fs::path>& more_folders, Loading loading) {
  Diagnostics of_user;
  std::vector<fs::path> folders = folders_of_user(of_user);
  // The program may be an interpreter, beside which another installation lies.
  std::ranges::copy(more_folders.empty() ? folders_beside() : more_folders, std::back_inserter(folders));
  std::error_code error;
  for (const PluginPath& named : from_config) {
    const auto& [path, origin, pointer] = named;
    if (!fs::exists(path, error))
      diagnostics.error("B040", origin, pointer, "there is no plugin file or folder '" + path.string() + "'");
    else if (!is_trusted(named, folders))
      report_untrusted(named, diagnostics);
    else if (fs::is_directory(path, error))
      load_folder(path, loading, diagnostics);
    else
      load(path, diagnostics);
  }
  diagnostics.merge(of_user);
  for (const auto& folder : folders) load_folder(folder, loading, diagnostics);
}

namespace {

using base::in_quotes;
using base::joined;

std::string article(const std::string& noun) {
  return (std::string_view("aeiou").find(noun.front()) != std::string_view::npos ? "an " : "a ") + noun;
}

/// Of the plugin in a library that is not loaded, where its guard can be read.
std::string name_in(const fs::path& file) {
  const plugin::LibraryFile library = plugin::inspect_library(plugin::OpenFile(file));
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
    report("B047", unknown + in_quotes(file.string()) + " may contain it, but is not loaded: " + why +
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
