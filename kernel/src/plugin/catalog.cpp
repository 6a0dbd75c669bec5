// SPDX-License-Identifier: Apache-2.0
// The catalog: where plugins are searched, and how a type's name finds its component.
#include "binnacle/catalog.hpp"

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <optional>
#include <set>
#include <system_error>
#include <tuple>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/runtime_symbol_info.hpp>

#include "base/text.hpp"
#include "plugin/guard.hpp"
#include "plugin/library_file.hpp"
#include "plugin/loader.hpp"

namespace binnacle {

namespace fs = std::filesystem;

const char* role_name(Role role) {
  switch (role) {
    case Role::state_block: return "state block";
    case Role::process_model: return "process model";
    case Role::measurement_model: return "measurement model";
    case Role::derived_block: return "derived block";
    case Role::noise_estimator: return "noise estimator";
    case Role::source: return "source";
    case Role::transform: return "transform";
    case Role::sink: return "sink";
  }
  return "component";
}

std::vector<std::string> exported_symbols(const fs::path& file) { return plugin::inspect_library(file).exported; }

std::vector<std::pair<std::string, std::string>> host_guard() { return abi::fields_of(abi::guard_of_host()); }

// ---- where

namespace {

/// As given, since a folder that is not there should be reported by the name that the user wrote.
std::vector<fs::path> folders_of_environment() {
  std::vector<fs::path> folders;
  const char* text = std::getenv("BINNACLE_PLUGIN_PATH");
  std::string_view rest = text ? text : "";
  while (!rest.empty()) {
    const std::size_t end = rest.find(':');
    const std::string_view folder = rest.substr(0, end);
    if (!folder.empty()) folders.emplace_back(folder);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  return folders;
}

std::optional<fs::path> folder_of_program() {
  std::error_code error;
  const fs::path program = boost::dll::program_location(error);
  if (error) return std::nullopt;
  return (program.parent_path() / ".." / "lib" / "binnacle").lexically_normal();
}

/// In order of their names, so that messages come in the same order everywhere.
std::vector<fs::path> libraries_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == ".so") files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

}  // namespace

std::vector<fs::path> plugin_folders() {
  std::vector<fs::path> folders = folders_of_environment();
  if (const auto folder = folder_of_program()) folders.push_back(*folder);
  return folders;
}

namespace {

/// A library of a searched folder that could not be loaded, and why, in a line.
struct PassedOver {
  fs::path file;
  std::string name;  // of the plugin, where its guard could be read
  std::string why;
};

std::string name_in(const fs::path& file) {
  const plugin::LibraryFile library = plugin::inspect_library(file);
  return library.guard ? abi::text_of(library.guard->name) : "";
}

/// The first error, and how many more there are.
std::string in_a_line(const Diagnostics& diagnostics) {
  std::string first;
  std::size_t count = 0;
  for (const Diagnostic& item : diagnostics.items())
    if (item.severity == Severity::error && count++ == 0) first = item.message;
  return count > 1 ? first + " (and " + std::to_string(count - 1) + " more)" : first;
}

}  // namespace

struct Catalog::Contents {
  std::set<fs::path> seen;  // canonical
  std::vector<PassedOver> passed_over;
  std::vector<PluginInfo> plugins;
  std::deque<ComponentType> components;  // a deque: pointers stay good while plugins are added
};

Catalog::Catalog() : contents_(std::make_unique<Contents>()) {}
Catalog::~Catalog() = default;
Catalog::Catalog(Catalog&&) noexcept = default;
Catalog& Catalog::operator=(Catalog&&) noexcept = default;

void Catalog::load(const fs::path& file, Diagnostics& diagnostics) {
  std::error_code error;
  fs::path canonical = fs::canonical(file, error);
  if (error) canonical = fs::absolute(file);
  if (!contents_->seen.insert(canonical).second) return;
  const auto is_new = [&](const PluginInfo& info) {
    for (const PluginInfo& other : contents_->plugins) {
      if (other.name != info.name) continue;
      diagnostics.error("B046", {canonical.string(), 0, 0}, "",
                        "plugin '" + info.name + "' is loaded already, from " + other.file.string());
      return false;
    }
    return true;
  };
  std::optional<plugin::LoadedPlugin> plugin = plugin::load_plugin(canonical, diagnostics, is_new);
  if (!plugin) return;
  contents_->plugins.push_back(plugin->info);
  for (ComponentType& type : plugin->types) contents_->components.push_back(std::move(type));
}

void Catalog::load_folder(const fs::path& folder, Diagnostics& diagnostics) {
  for (const fs::path& file : libraries_in(folder)) {
    Diagnostics found;
    load(file, found);
    if (!found.has_errors()) {
      diagnostics.merge(found);
      continue;
    }
    const std::string why = in_a_line(found);
    contents_->passed_over.push_back({file, name_in(file), why});
    diagnostics.warning("B047", {file.string(), 0, 0}, "", "not loaded: " + why);
  }
}

void Catalog::load_search_path(const std::vector<PluginPath>& from_config, Diagnostics& diagnostics) {
  for (const PluginPath& entry : from_config) {
    std::error_code error;
    if (is_folder(entry.path)) {
      load_folder(entry.path, diagnostics);
    } else if (fs::exists(entry.path, error)) {
      load(entry.path, diagnostics);
    } else {
      diagnostics.error("B040", entry.origin, entry.pointer,
                        "there is no plugin file or folder '" + entry.path.string() + "'");
    }
  }
  for (const fs::path& folder : folders_of_environment()) {
    if (!is_folder(folder)) {
      diagnostics.warning("B040", {}, "", "BINNACLE_PLUGIN_PATH: there is no folder '" + folder.string() + "'");
    }
    load_folder(folder, diagnostics);
  }
  if (const auto folder = folder_of_program()) load_folder(*folder, diagnostics);
}

// ---- names

namespace {

bool is_called(const ComponentType& type, std::string_view name) {
  return type.spec.type == name || (name.find('/') != std::string_view::npos && type.full_name() == name);
}

/// The one that had this full name in an earlier version.
template <class Types>
const ComponentType* named_before(const Types& types, std::string_view name) {
  for (const ComponentType& type : types)
    for (const std::string& former : type.spec.former_names)
      if (former == name) return &type;
  return nullptr;
}

using base::in_quotes;

std::string article(const std::string& noun) {
  return (std::string_view("aeiou").find(noun.front()) != std::string_view::npos ? "an " : "a ") + noun;
}

std::string plugin_names(const std::vector<PluginInfo>& plugins) {
  std::string text;
  for (const PluginInfo& plugin : plugins) text += (text.empty() ? "" : ", ") + plugin.name;
  return text.empty() ? "no plugin is loaded" : "none of the loaded plugins has it: " + text;
}

/// Short and full names, for the search of what was meant.
template <class Types, class Wanted>
std::vector<std::string> names_of(const Types& types, std::string_view like, const Wanted& wanted) {
  const bool full = like.find('/') != std::string_view::npos;
  std::vector<std::string> names;
  for (const ComponentType& type : types) {
    if (wanted(type)) names.push_back(full ? type.full_name() : type.spec.type);
  }
  return names;
}

}  // namespace

const ComponentType* Catalog::find(Role role, std::string_view name) const {
  const ComponentType* found = nullptr;
  for (const ComponentType& type : contents_->components) {
    if (type.role != role || !is_called(type, name)) continue;
    if (found) return nullptr;
    found = &type;
  }
  return found;
}

const ComponentType* Catalog::find(Role role, std::string_view name, const Origin& origin, const std::string& pointer,
                                   Diagnostics& diagnostics) const {
  if (const ComponentType* type = find(role, name)) return type;
  std::vector<std::string> alternatives;
  const ComponentType* elsewhere = nullptr;
  for (const ComponentType& type : contents_->components) {
    if (!is_called(type, name)) continue;
    if (type.role == role) {
      alternatives.push_back(type.full_name());
    } else {
      elsewhere = &type;
    }
  }
  if (!alternatives.empty()) {
    std::sort(alternatives.begin(), alternatives.end());
    std::string list;
    for (const std::string& full : alternatives) list += (list.empty() ? "" : " or ") + in_quotes(full);
    diagnostics.error("B022", origin, pointer, in_quotes(name) + " is ambiguous; write " + list);
    return nullptr;
  }
  const std::string wanted = role_name(role);
  if (const ComponentType* renamed = named_before(contents_->components, name); renamed && renamed->role == role) {
    diagnostics.error("B011", origin, pointer, in_quotes(name) + " is now called " + in_quotes(renamed->full_name()));
    return nullptr;
  }
  if (elsewhere) {
    diagnostics.error("B011", origin, pointer,
                      in_quotes(name) + " is " + article(role_name(elsewhere->role)) + ", not " + article(wanted));
    return nullptr;
  }
  const std::string near = closest(name, names_of(contents_->components, name,
                                                  [&](const ComponentType& type) { return type.role == role; }));
  const std::string unknown = "unknown " + wanted + " " + in_quotes(name) + "; ";
  const std::string meant = near.empty() ? "" : "did you mean " + in_quotes(near) + "?";
  // What a library brings is known once it is loaded; its name is known before.
  const std::string_view plugin = name.substr(0, name.find('/') == std::string_view::npos ? 0 : name.find('/'));
  bool may_be_there = false;
  for (const auto& library : contents_->passed_over) {
    if (!plugin.empty() && !library.name.empty() && library.name != plugin) continue;
    may_be_there = true;
    diagnostics.error("B047", origin, pointer,
                      unknown + in_quotes(library.file.string()) + " may have it, but is not loaded: " + library.why +
                          (meant.empty() ? "" : "; " + meant));
  }
  if (!may_be_there)
    diagnostics.error("B011", origin, pointer, unknown + (meant.empty() ? plugin_names(plugins()) : meant));
  return nullptr;
}

std::vector<const ComponentType*> Catalog::find_all(std::string_view name) const {
  std::vector<const ComponentType*> found;
  for (const ComponentType* type : types()) {
    if (is_called(*type, name)) found.push_back(type);
  }
  return found;
}

std::string Catalog::nearest(std::string_view name) const {
  if (const ComponentType* renamed = named_before(contents_->components, name)) return renamed->full_name();
  return closest(name, names_of(contents_->components, name, [](const ComponentType&) { return true; }));
}

std::vector<const ComponentType*> Catalog::types() const {
  std::vector<const ComponentType*> types;
  for (const ComponentType& type : contents_->components) types.push_back(&type);
  std::sort(types.begin(), types.end(), [](const ComponentType* a, const ComponentType* b) {
    return std::tie(a->role, a->plugin, a->spec.type) < std::tie(b->role, b->plugin, b->spec.type);
  });
  return types;
}

std::vector<PluginInfo> Catalog::plugins() const {
  std::vector<PluginInfo> plugins = contents_->plugins;
  std::sort(plugins.begin(), plugins.end(), [](const PluginInfo& a, const PluginInfo& b) { return a.name < b.name; });
  return plugins;
}

}  // namespace binnacle
