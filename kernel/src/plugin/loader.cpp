// SPDX-License-Identifier: Apache-2.0
// Loading one plugin file, and the library boundary at which what a plugin throws is caught.
#include <algorithm>
#include <cctype>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <utility>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/shared_library.hpp>

#include "plugin/library.hpp"
#include "spec/check.hpp"

namespace binnacle::internal::plugin {

namespace fs = std::filesystem;

namespace {

bool is_name(const std::string& text) {
  const auto allowed = [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '_'; };
  return !text.empty() && std::islower(static_cast<unsigned char>(text.front())) && std::ranges::all_of(text, allowed);
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// "… (dlerror system message: X)" is X.
std::string loader_message(const std::string& text) {
  constexpr std::string_view before = "(dlerror system message: ";
  const std::size_t start = text.find(before);
  const std::size_t end = text.rfind(')');
  if (start == std::string::npos || end == std::string::npos) return text;
  return text.substr(start + before.size(), end - start - before.size());
}

bool refuse(Diagnostics& diagnostics, const PluginInfo& info, const char* code, std::string text) {
  diagnostics.error(code, {info.file.string(), 0, 0}, "", std::move(text));
  return false;
}

bool check_name(const PluginInfo& info, Others others, Diagnostics& diagnostics) {
  if (!is_name(info.name))
    return refuse(diagnostics, info, "B045", "the plugin's name '" + info.name + "' is not in snake_case");
  for (const auto* list : others)
    if (const auto other = std::ranges::find(*list, info.name, &PluginInfo::name); other != list->end())
      return refuse(diagnostics, info, "B046",
                    "plugin '" + info.name + "' is loaded already, from " +
                        (other->file.empty() ? "the program itself" : other->file.string()));
  return true;
}

/// Looks at a file none of whose code may run yet. What is wrong goes to the diagnostics; checks say whether it is good.
class Examination {
 public:
  Examination(const fs::path& file, Diagnostics& diagnostics) : diagnostics_(diagnostics) { info_.file = file; }

  std::optional<PluginInfo> outcome(Others others) {
    if (!check_file()) return std::nullopt;
    const LibraryFile library = inspect_library(info_.file);
    if (!check_exports(library) || !check_guard(*library.guard)) return std::nullopt;
    info_.name = abi::text_of(library.guard->name);
    info_.version = abi::text_of(library.guard->version);
    info_.listed = words(library.types);
    return check_name(info_, others, diagnostics_) ? std::optional(info_) : std::nullopt;
  }

 private:
  bool check_file() {
    std::error_code error;
    const fs::file_status status = fs::status(info_.file, error);
    if (error) return refuse(diagnostics_, info_, "B040", "the plugin cannot be opened: " + error.message());
    if (!fs::is_regular_file(status)) return refuse(diagnostics_, info_, "B040", "the plugin is not a file");
    if ((status.permissions() & fs::perms::others_write) != fs::perms::none)
      return refuse(diagnostics_, info_, "B044",
                    "the plugin file is world-writable, so it is not loaded; chmod o-w it");
    return true;
  }

  bool check_exports(const LibraryFile& library) {
    const auto no_plugin = [&](const std::string& why) {
      return refuse(diagnostics_, info_, "B041", "not a plugin for this program: " + why);
    };
    if (!library.unreadable.empty()) return no_plugin(library.unreadable);
    if (!library.guard && !library.other_guard.empty())
      return no_plugin("it is one for another major version (exports " + library.other_guard + ", not " + guard_symbol +
                       ")");
    if (!library.guard) return no_plugin("it exports no " + std::string(guard_symbol));
    const bool has_register = std::ranges::find(library.exported, register_symbol) != library.exported.end();
    return has_register || no_plugin("it exports no " + std::string(register_symbol));
  }

  bool check_guard(const abi::Guard& guard) {
    bool is_good = true;
    for (const auto& difference : abi::compare(abi::guard_of_host(), guard, abi::processor_instruction_sets()))
      if (difference.severity == abi::Severity::refused)
        is_good = refuse(diagnostics_, info_, "B042", difference.text());
      else
        diagnostics_.warning("B043", {info_.file.string(), 0, 0}, "", difference.text());
    return is_good;
  }

  PluginInfo info_;
  Diagnostics& diagnostics_;
};

}  // namespace

/// Loads a file and collects what it registers. What is wrong with it goes to the diagnostics, all at its place; checks
/// say whether it is good.
class PluginRegistry final : public Registry {
 public:
  PluginRegistry(std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types, Diagnostics& diagnostics)
      : plugins_(plugins), all_types_(types), diagnostics_(diagnostics) {}

  bool load(const PluginInfo& plugin) {
    info_ = plugin;
    return take_types(register_symbol, [&] {
      using namespace boost::dll;
      auto library = std::make_shared<shared_library>(info_.file, load_mode::rtld_now | load_mode::rtld_local);
      library_ = library;
      return [library](Registry& registry) { library->get<void(Registry&)>(register_symbol)(registry); };
    });
  }

  /// In the memory of the library.
  static const void* address_of(const ComponentType& type) { return reinterpret_cast<const void*>(type.factory_); }

  bool link(std::shared_ptr<const LinkedPlugin> plugin) {
    info_ = {plugin->name, plugin->version, {}};
    library_ = plugin;
    return check_name(info_, {&plugins_}, diagnostics_) && take_types("add_types", [&] { return plugin->add_types; });
  }

 protected:
  void add_component(Role role, ComponentSpec spec, AnyFactory factory) override {
    ComponentType& type = types_.emplace_back();
    type.role = role;
    type.spec = std::move(spec);
    type.plugin = info_.name;
    type.plugin_version = info_.version;
    type.factory_ = factory;
    type.library_ = library_;
  }

 private:
  /// open() gives what registers its types.
  template <class Open>
  bool take_types(const std::string& call, Open&& open) {
    CallSite site;
    const std::string itself;
    site.enter(&info_.name, itself, "loading it");
    const CallScope scope(site);
    std::function<void(Registry&)> add_types;
    try {
      add_types = open();
    } catch (const std::exception& error) {
      return refuse(diagnostics_, info_, "B045", "the plugin cannot be loaded: " + loader_message(error.what()));
    }
    try {
      add_types(*this);
    } catch (...) {
      // The message is made inside the handler and the exception gone at its end, before the library may be.
      return refuse(diagnostics_, info_, "B045",
                    "plugin '" + info_.name + "': " + call + " threw: " + what_was_thrown());
    }
    if (!check_types()) return false;
    plugins_.push_back(info_);
    std::ranges::move(types_, std::back_inserter(all_types_));
    return true;
  }

  bool check_types() {
    bool is_good = true;
    std::set<std::string> seen;
    for (const ComponentType& type : types_) {
      const ComponentSpec& spec = type.spec;
      const std::string who = "plugin '" + info_.name + "', component '" + spec.type + "': ";
      if (!is_name(spec.type)) is_good = refuse(diagnostics_, info_, "B045", who + "its type is no name in snake_case");
      for (const std::string& defect : spec::spec_defects(spec))
        is_good = refuse(diagnostics_, info_, "B045", who + defect);
      if (!seen.insert(spec.type).second)
        is_good =
            refuse(diagnostics_, info_, "B046", "plugin '" + info_.name + "' registers '" + spec.type + "' twice");
    }
    return check_list(seen) && is_good;
  }

  /// Where it lists its types, those that it registers are the same.
  bool check_list(const std::set<std::string>& registered) {
    if (info_.listed.empty()) return true;
    bool is_good = true;
    const std::string who = "plugin '" + info_.name + "' ";
    const std::set<std::string> listed(info_.listed.begin(), info_.listed.end());
    for (const auto& type : registered)
      if (!listed.contains(type))
        is_good = refuse(diagnostics_, info_, "B045", who + "registers '" + type + "', which its BINNACLE_TYPES lacks");
    for (const auto& type : listed)
      if (!registered.contains(type))
        is_good = refuse(diagnostics_, info_, "B045",
                         who + "lists '" + type + "' in its BINNACLE_TYPES, and does not register it");
    return is_good;
  }

  std::vector<PluginInfo>& plugins_;
  std::deque<ComponentType>& all_types_;
  Diagnostics& diagnostics_;
  PluginInfo info_;
  std::shared_ptr<const void> library_;
  std::vector<ComponentType> types_;
};

std::string contents_of(const ComponentType& type, const std::vector<PluginInfo>& plugins) {
  const auto plugin = std::ranges::find(plugins, type.plugin, &PluginInfo::name);
  if (plugin == plugins.end() || plugin->file.empty()) return "";
  return build_of(PluginRegistry::address_of(type), plugin->file);
}

std::optional<PluginInfo> examine_plugin(const fs::path& file, Others others, Diagnostics& diagnostics) {
  return Examination(file, diagnostics).outcome(others);
}

void load_plugin(const PluginInfo& plugin, std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types,
                 Diagnostics& diagnostics) {
  PluginRegistry(plugins, types, diagnostics).load(plugin);
}

void link_plugin(std::shared_ptr<const LinkedPlugin> plugin, std::vector<PluginInfo>& plugins,
                 std::deque<ComponentType>& types, Diagnostics& diagnostics) {
  PluginRegistry(plugins, types, diagnostics).link(std::move(plugin));
}

}  // namespace binnacle::internal::plugin

namespace binnacle {

ComponentError ComponentType::component_error(const std::string& text) {
  // A copy: the plugin's own exception object may not outlive its library.
  try {
    throw;
  } catch (const ComponentError& error) {
    return error;
  } catch (...) {
    return ComponentError(text);
  }
}

}  // namespace binnacle
