// SPDX-License-Identifier: Apache-2.0
// Catalog: the component types that the loaded plugins bring, how they are found, made, and described.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/plugin_call.hpp"
#include "binnacle/registry.hpp"
#include "binnacle/spec.hpp"

namespace binnacle {

namespace internal::plugin {
class PluginRegistry;
}

inline constexpr Role all_roles[] = {Role::state_block,       Role::process_model,
                                     Role::measurement_model, Role::derived_block,
                                     Role::noise_estimator,   Role::source,
                                     Role::transform,         Role::sink};

/// "state block", "process model", …
const char* role_name(Role role);

/// One component type of a loaded plugin. Copies and everything it makes keep the plugin's library loaded.
///
/// What a constructor throws is caught at the library boundary: a ComponentError passes as it is, anything else becomes a
/// ComponentError that names plugin, component and call. Either is a copy made by the host.
class ComponentType {
 public:
  Role role = Role::state_block;
  ComponentSpec spec;
  std::string plugin;          // "core"
  std::string plugin_version;  // "1.0.0"

  /// "core/vector"
  std::string full_name() const { return plugin + "/" + spec.type; }

  /// A component of this type, of the role's interface; of another role: std::logic_error. `noise`: what an estimator is
  /// bound to.
  ///
  ///     std::shared_ptr<Source> source = type.create<Source>(binding);
  template <class Base>
  std::shared_ptr<Base> create(const Binding& binding, const NoiseBinding& noise = {}) const {
    if (role != role_of<Base>())
      throw std::logic_error(full_name() + " is a " + role_name(role) + ", not a " + role_name(role_of<Base>()));
    return guarded("its constructor", [&] {
      std::unique_ptr<Base> object = reinterpret_cast<Factory<Base>>(factory_)(binding, noise);
      // The deleter outlives the object that it deletes, and with it the library that has the destructor's code.
      return std::shared_ptr<Base>(object.release(), [library = library_](Base* base) { delete base; });
    });
  }

  /// Runs a call into an object of this type (Source::open, say) with the same care: what escapes is a ComponentError
  /// of the host. Meanwhile plugin_call_under_way() names it; `t`: of the sample at work.
  template <class Call>
  auto guarded(const char* call_name, Call&& call, Time t = no_time) const {
    return call_plugin(&plugin, spec.type, call_name, t, std::forward<Call>(call), component_error);
  }

 private:
  friend class internal::plugin::PluginRegistry;

  static ComponentError component_error(const std::string& text);

  AnyFactory factory_ = nullptr;  // of the role's signature
  std::shared_ptr<const void> library_;
};

/// A plugin that is no file but part of the program; its types are found by name like those of any other. It lives as long as
/// anything that is made of it.
struct LinkedPlugin {
  std::string name;     // "my_models", in snake_case
  std::string version;  // part of what a snapshot is of: another version refuses it
  std::function<void(Registry& registry)> add_types;
};

/// A plugin that was loaded, or waits until a type of it is wanted.
struct PluginInfo {
  std::string name;
  std::string version;
  std::filesystem::path file;            // empty: it is linked into the program
  std::vector<std::string> listed = {};  // its types, as BINNACLE_TYPES names them; empty where it does not
};

/// An entry of the config's "plugins": a library, or a folder whose *.so are all loaded. Absolute.
struct PluginPath {
  std::filesystem::path path;
  Origin origin;
  std::string pointer;
};

/// The symbols that a library file exports, read without loading it; empty where it is none.
std::vector<std::string> exported_symbols(const std::filesystem::path& file);

/// Whatever is wrong goes to the diagnostics (codes B040…B047), to be thrown by the caller as LoadError.
class Catalog {
 public:
  /// When libraries of searched folders that list their types (BINNACLE_TYPES) are loaded: with the others, or not before
  /// want() is asked for one of the types. Their guards are checked at once either way.
  enum class Loading { at_once, when_wanted };

  /// Loads a plugin file; nothing happens if it is loaded already.
  void load(const std::filesystem::path& file, Diagnostics& diagnostics);
  /// Adds a plugin of the program.
  void add(std::shared_ptr<const LinkedPlugin> plugin, Diagnostics& diagnostics);
  /// Loads the config's plugins, then those in the folders of BINNACLE_PLUGIN_PATH (separated by ':'), and in `more_folders`; where these are none, in lib/binnacle
  /// beside the folder of the running program, which is the installed and the build tree's. What is named and cannot be
  /// loaded is an error; what merely lies in a folder is a warning (B047), and an error once find() wants a type that it
  /// may have.
  void load_search_path(const std::vector<PluginPath>& from_config, Diagnostics& diagnostics,
                        const std::vector<std::filesystem::path>& more_folders = {},
                        Loading loading = Loading::at_once);
  /// Loads what waits. What cannot be loaded is a warning (B047).
  void load_waiting(Diagnostics& diagnostics);

  /// `name`: "vector" or "core/vector". Null where there is none, or several.
  const ComponentType* find(Role role, std::string_view name) const;
  /// As above, reporting what is wrong: unknown with the nearest name (B011), perhaps in a library that was not loaded
  /// (B047), or ambiguous with the full names (B022).
  const ComponentType* find(Role role, std::string_view name, const Origin& origin, const std::string& pointer,
                            Diagnostics& diagnostics) const;

  /// As find(), of plugins that wait too: loads those that list the name, and all of them before anything is reported, for
  /// the nearest name may be any one's.
  const ComponentType* want(Role role, std::string_view name, const Origin& origin, const std::string& pointer,
                            Diagnostics& diagnostics);

  /// Of the plugins that are loaded, by role, then by full name. Pointers live as long as the catalog.
  std::vector<const ComponentType*> types() const;
  /// Those that wait too, by name.
  std::vector<PluginInfo> plugins() const;

 private:
  void load_folder(const std::filesystem::path& folder, Loading loading, Diagnostics& diagnostics);
  /// Loads the library, or lets it wait; errors where it cannot be.
  void take(const std::filesystem::path& file, Loading loading, Diagnostics& diagnostics);
  /// What is found of a library of a searched folder: with errors, a warning that it is passed over, and why.
  void note(const std::filesystem::path& file, const Diagnostics& found, Diagnostics& diagnostics);
  template <class Predicate>
  void load_waiting_that(const Predicate& is_wanted, Diagnostics& diagnostics);

  std::set<std::filesystem::path> seen_;  // canonical
  /// Libraries of searched folders that could not be loaded, and why, in a line.
  std::vector<std::pair<std::filesystem::path, std::string>> passed_over_;
  std::vector<PluginInfo> plugins_, waiting_;
  std::deque<ComponentType> components_;  // a deque: pointers stay good while plugins are added
};

/// "s, > 0": unit and range of the parameter, or what else its value has to be.
std::string requirement_text(const ParameterSpec& spec);
/// The default, or a number, time, vector or matrix as one would write it, inside its range, as JSON text: "\"1 h\"".
std::string example_text(const ParameterSpec& spec);

/// This program's ABI guard against a plugin's, for `binnacle version`: one line per field, "name: value".
std::vector<std::pair<std::string, std::string>> host_guard();

}  // namespace binnacle
