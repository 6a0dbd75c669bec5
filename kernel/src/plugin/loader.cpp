// SPDX-License-Identifier: Apache-2.0
// Loading one plugin file, and the library boundary at which what a plugin throws is caught.
#include "plugin/loader.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <exception>
#include <string>
#include <utility>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/shared_library.hpp>

#include "plugin/guard.hpp"
#include "plugin/library_file.hpp"
#include "spec/check.hpp"

namespace binnacle::plugin {

using Library = boost::dll::shared_library;

/// Collects what a plugin registers.
class PluginRegistry final : public Registry {
 public:
  PluginRegistry(const PluginInfo& info, std::shared_ptr<const void> library)
      : info_(info), library_(std::move(library)) {}

  std::vector<ComponentType> types;

 protected:
  void add_state_block(ComponentSpec spec, Factory<StateBlock> factory) override {
    add_type(Role::state_block, std::move(spec), factory);
  }
  void add_process_model(ComponentSpec spec, Factory<ProcessModel> factory) override {
    add_type(Role::process_model, std::move(spec), factory);
  }
  void add_measurement_model(ComponentSpec spec, Factory<MeasurementModel> factory) override {
    add_type(Role::measurement_model, std::move(spec), factory);
  }
  void add_derived_block(ComponentSpec spec, Factory<DerivedBlock> factory) override {
    add_type(Role::derived_block, std::move(spec), factory);
  }
  void add_noise_estimator(ComponentSpec spec, NoiseFactory factory) override {
    add_type(Role::noise_estimator, std::move(spec), factory);
  }
  void add_source(ComponentSpec spec, Factory<Source> factory) override {
    add_type(Role::source, std::move(spec), factory);
  }
  void add_transform(ComponentSpec spec, Factory<Transform> factory) override {
    add_type(Role::transform, std::move(spec), factory);
  }
  void add_sink(ComponentSpec spec, Factory<Sink> factory) override { add_type(Role::sink, std::move(spec), factory); }

 private:
  template <class MakeFunction>
  void add_type(Role role, ComponentSpec spec, MakeFunction factory) {
    ComponentType type;
    type.role = role;
    type.spec = std::move(spec);
    type.plugin = info_.name;
    type.plugin_version = info_.version;
    type.file = info_.file;
    type.factory_ = reinterpret_cast<ComponentType::AnyFactory>(factory);
    type.library_ = library_;
    types.push_back(std::move(type));
  }

  const PluginInfo& info_;
  std::shared_ptr<const void> library_;
};

}  // namespace binnacle::plugin

namespace binnacle {

// ---- the library boundary

namespace {

/// Of an exception that is being handled; nothing of the plugin's is referred to.
std::string what_was_thrown() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "something that is no std::exception";
  }
}

template <class Base>
std::shared_ptr<Base> keeping(std::unique_ptr<Base> object, const std::shared_ptr<const void>& library) {
  // The deleter outlives the object that it deletes, and with it the library that has the destructor's code.
  return std::shared_ptr<Base>(object.release(), [library](Base* base) { delete base; });
}

template <class Function>
Function typed(void (*factory)()) {
  return reinterpret_cast<Function>(factory);
}

}  // namespace

void ComponentType::rethrow_as_component_error(const CallSite& site) {
  // Copies: the plugin's own exception object may not outlive its library.
  std::string message;
  try {
    throw;
  } catch (const ComponentError& error) {
    ComponentError copy = error;
    throw copy;
  } catch (...) {
    message = site.text() + " threw: " + what_was_thrown();
  }
  throw ComponentError(message);
}

template <class Base>
std::shared_ptr<Base> ComponentType::create(Role wanted, const Binding& binding) const {
  if (role != wanted) throw std::logic_error(full_name() + " is a " + role_name(role) + ", not a " + role_name(wanted));
  return guarded("its constructor", [&] { return keeping(typed<Factory<Base>>(factory_)(binding), library_); });
}

std::shared_ptr<StateBlock> ComponentType::create_state_block(const Binding& binding) const {
  return create<StateBlock>(Role::state_block, binding);
}
std::shared_ptr<ProcessModel> ComponentType::create_process_model(const Binding& binding) const {
  return create<ProcessModel>(Role::process_model, binding);
}
std::shared_ptr<MeasurementModel> ComponentType::create_measurement_model(const Binding& binding) const {
  return create<MeasurementModel>(Role::measurement_model, binding);
}
std::shared_ptr<DerivedBlock> ComponentType::create_derived_block(const Binding& binding) const {
  return create<DerivedBlock>(Role::derived_block, binding);
}
std::shared_ptr<NoiseEstimator> ComponentType::create_noise_estimator(const Binding& binding,
                                                                      const NoiseBinding& noise) const {
  if (role != Role::noise_estimator) throw std::logic_error(full_name() + " is no noise estimator");
  return guarded("its constructor", [&] { return keeping(typed<NoiseFactory>(factory_)(binding, noise), library_); });
}
std::shared_ptr<Source> ComponentType::create_source(const Binding& binding) const {
  return create<Source>(Role::source, binding);
}
std::shared_ptr<Transform> ComponentType::create_transform(const Binding& binding) const {
  return create<Transform>(Role::transform, binding);
}
std::shared_ptr<Sink> ComponentType::create_sink(const Binding& binding) const {
  return create<Sink>(Role::sink, binding);
}

}  // namespace binnacle

namespace binnacle::plugin {

// ---- loading

namespace {

Origin place(const std::filesystem::path& file) { return {file.string(), 0, 0}; }

bool check_file(const std::filesystem::path& file, Diagnostics& diagnostics) {
  struct ::stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    diagnostics.error("B040", place(file), "", std::string("the plugin cannot be opened: ") + std::strerror(errno));
    return false;
  }
  if (!S_ISREG(status.st_mode)) {
    diagnostics.error("B040", place(file), "", "the plugin is not a file");
    return false;
  }
  if (status.st_mode & S_IWOTH) {
    diagnostics.error("B044", place(file), "", "the plugin file is world-writable, so it is not loaded; chmod o-w it");
    return false;
  }
  return true;
}

std::optional<abi::Guard> check_exports(const std::filesystem::path& file, Diagnostics& diagnostics) {
  const LibraryFile library = inspect_library(file);
  std::string reason;
  if (!library.unreadable.empty()) {
    reason = library.unreadable;
  } else if (!library.guard) {
    reason = library.other_guard.empty() ? std::string("it exports no ") + guard_symbol
                                         : "it is one for another major version (exports " + library.other_guard +
                                               ", not " + guard_symbol + ")";
  } else if (!library.has_register) {
    reason = std::string("it exports no ") + register_symbol;
  }
  if (reason.empty()) return library.guard;
  diagnostics.error("B041", place(file), "", "not a plugin for this program: " + reason);
  return std::nullopt;
}

bool check_guard(const std::filesystem::path& file, const abi::Guard& guard, Diagnostics& diagnostics) {
  bool is_refused = false;
  for (const abi::Difference& difference :
       abi::compare(abi::guard_of_host(), guard, abi::processor_instruction_sets())) {
    const bool refused = difference.severity == abi::Severity::refused;
    is_refused |= refused;
    diagnostics.add({refused ? Severity::error : Severity::warning, refused ? "B042" : "B043", place(file), "",
                     abi::to_string(difference)});
  }
  return !is_refused;
}

bool is_name(const std::string& text) {
  const auto allowed = [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '_'; };
  return !text.empty() && std::islower(static_cast<unsigned char>(text.front())) &&
         std::all_of(text.begin(), text.end(), allowed);
}

/// "… (dlerror system message: X)" is X.
std::string loader_message(const std::string& text) {
  constexpr std::string_view before = "(dlerror system message: ";
  const std::size_t start = text.find(before);
  const std::size_t end = text.rfind(')');
  if (start == std::string::npos || end == std::string::npos) return text;
  return text.substr(start + before.size(), end - start - before.size());
}

std::shared_ptr<Library> open_library(const std::filesystem::path& file, Diagnostics& diagnostics) {
  try {
    return std::make_shared<Library>(file, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  } catch (const std::exception& error) {
    diagnostics.error("B045", place(file), "", "the plugin cannot be loaded: " + loader_message(error.what()));
    return nullptr;
  }
}

bool register_types(const std::shared_ptr<Library>& library, PluginRegistry& registry, const PluginInfo& info,
                    Diagnostics& diagnostics) {
  // The message is made inside the handler and the exception gone at its end, before the library may be.
  try {
    library->get<void(Registry&)>(register_symbol)(registry);
    return true;
  } catch (...) {
    diagnostics.error("B045", place(info.file), "",
                      "plugin '" + info.name + "': " + register_symbol + " threw: " + what_was_thrown());
  }
  return false;
}

bool check_types(const PluginInfo& info, const std::vector<ComponentType>& types, Diagnostics& diagnostics) {
  bool good = true;
  const auto refuse = [&](const char* code, std::string message) {
    diagnostics.error(code, place(info.file), "", std::move(message));
    good = false;
  };
  for (std::size_t i = 0; i < types.size(); ++i) {
    const ComponentSpec& spec = types[i].spec;
    const std::string who = "plugin '" + info.name + "', component '" + spec.type + "': ";
    if (!is_name(spec.type)) refuse("B045", who + "its type is no name in snake_case");
    for (const std::string& defect : spec::spec_defects(spec)) refuse("B045", who + defect);
    for (std::size_t j = 0; j < i; ++j) {
      if (types[j].spec.type == spec.type) {
        refuse("B046", "plugin '" + info.name + "' registers '" + spec.type + "' twice");
        break;
      }
    }
  }
  return good;
}

}  // namespace

std::optional<LoadedPlugin> load_plugin(const std::filesystem::path& file, Diagnostics& diagnostics,
                                        const std::function<bool(const PluginInfo&)>& accept) {
  if (!check_file(file, diagnostics)) return std::nullopt;
  const std::optional<abi::Guard> guard = check_exports(file, diagnostics);
  if (!guard || !check_guard(file, *guard, diagnostics)) return std::nullopt;
  LoadedPlugin plugin{{abi::text_of(guard->name), abi::text_of(guard->version), file}, {}};
  if (!is_name(plugin.info.name)) {
    diagnostics.error("B045", place(file), "", "the plugin's name '" + plugin.info.name + "' is not in snake_case");
    return std::nullopt;
  }
  if (!accept(plugin.info)) return std::nullopt;
  CallSite site;
  const std::string itself;
  site.enter(&plugin.info.name, itself, "loading it");
  const CallScope scope(site);
  const std::shared_ptr<Library> library = open_library(file, diagnostics);
  if (!library) return std::nullopt;
  PluginRegistry registry(plugin.info, library);
  if (!register_types(library, registry, plugin.info, diagnostics) ||
      !check_types(plugin.info, registry.types, diagnostics)) {
    return std::nullopt;
  }
  plugin.types = std::move(registry.types);
  return plugin;
}

}  // namespace binnacle::plugin
