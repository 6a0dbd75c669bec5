// SPDX-License-Identifier: Apache-2.0
// Loading one plugin file, and the library boundary at which what a plugin throws is caught.
#include <algorithm>
#include <cctype>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <set>
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

/// "… (dlerror system message: X)" is X.
std::string loader_message(const std::string& text) {
  constexpr std::string_view before = "(dlerror system message: ";
  const std::size_t start = text.find(before);
  const std::size_t end = text.rfind(')');
  if (start == std::string::npos || end == std::string::npos) return text;
  return text.substr(start + before.size(), end - start - before.size());
}

}  // namespace

/// Loads a file and collects what it registers. What is wrong with it goes to the diagnostics, all at its place; checks
/// say whether it is good.
class PluginRegistry final : public Registry {
 public:
  PluginRegistry(std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types, Diagnostics& diagnostics)
      : plugins_(plugins), all_types_(types), diagnostics_(diagnostics) {}

  bool load(const fs::path& file) {
    info_.file = file;
    if (!check_file()) return false;
    const LibraryFile inspected = inspect_library(file);
    if (!check_exports(inspected) || !check_guard(*inspected.guard)) return false;
    info_ = {abi::text_of(inspected.guard->name), abi::text_of(inspected.guard->version), file};
    return take_types(register_symbol, [&] {
      using namespace boost::dll;
      auto library = std::make_shared<shared_library>(file, load_mode::rtld_now | load_mode::rtld_local);
      library_ = library;
      return [library](Registry& registry) { library->get<void(Registry&)>(register_symbol)(registry); };
    });
  }

  bool link(std::shared_ptr<const LinkedPlugin> plugin) {
    info_ = {plugin->name, plugin->version, {}};
    library_ = plugin;
    return take_types("add_types", [&] { return plugin->add_types; });
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
    if (!is_name(info_.name)) return refuse("B045", "the plugin's name '" + info_.name + "' is not in snake_case");
    if (const auto other = std::ranges::find(plugins_, info_.name, &PluginInfo::name); other != plugins_.end())
      return refuse("B046", "plugin '" + info_.name + "' is loaded already, from " +
                                (other->file.empty() ? "the program itself" : other->file.string()));
    CallSite site;
    const std::string itself;
    site.enter(&info_.name, itself, "loading it");
    const CallScope scope(site);
    std::function<void(Registry&)> add_types;
    try {
      add_types = open();
    } catch (const std::exception& error) {
      return refuse("B045", "the plugin cannot be loaded: " + loader_message(error.what()));
    }
    try {
      add_types(*this);
    } catch (...) {
      // The message is made inside the handler and the exception gone at its end, before the library may be.
      return refuse("B045", "plugin '" + info_.name + "': " + call + " threw: " + what_was_thrown());
    }
    if (!check_types()) return false;
    plugins_.push_back(info_);
    std::ranges::move(types_, std::back_inserter(all_types_));
    return true;
  }

  bool refuse(const char* code, std::string text) {
    diagnostics_.error(code, {info_.file.string(), 0, 0}, "", std::move(text));
    return false;
  }

  bool check_file() {
    std::error_code error;
    const fs::file_status status = fs::status(info_.file, error);
    if (error) return refuse("B040", "the plugin cannot be opened: " + error.message());
    if (!fs::is_regular_file(status)) return refuse("B040", "the plugin is not a file");
    if ((status.permissions() & fs::perms::others_write) != fs::perms::none)
      return refuse("B044", "the plugin file is world-writable, so it is not loaded; chmod o-w it");
    return true;
  }

  bool check_exports(const LibraryFile& library) {
    const auto no_plugin = [&](const std::string& why) {
      return refuse("B041", "not a plugin for this program: " + why);
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
        is_good = refuse("B042", difference.text());
      else
        diagnostics_.warning("B043", {info_.file.string(), 0, 0}, "", difference.text());
    return is_good;
  }

  bool check_types() {
    bool is_good = true;
    std::set<std::string> seen;
    for (const ComponentType& type : types_) {
      const ComponentSpec& spec = type.spec;
      const std::string who = "plugin '" + info_.name + "', component '" + spec.type + "': ";
      if (!is_name(spec.type)) is_good = refuse("B045", who + "its type is no name in snake_case");
      for (const std::string& defect : spec::spec_defects(spec)) is_good = refuse("B045", who + defect);
      if (!seen.insert(spec.type).second)
        is_good = refuse("B046", "plugin '" + info_.name + "' registers '" + spec.type + "' twice");
    }
    return is_good;
  }

  std::vector<PluginInfo>& plugins_;
  std::deque<ComponentType>& all_types_;
  Diagnostics& diagnostics_;
  PluginInfo info_;
  std::shared_ptr<const void> library_;
  std::vector<ComponentType> types_;
};

void load_plugin(const fs::path& file, std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types,
                 Diagnostics& diagnostics) {
  PluginRegistry(plugins, types, diagnostics).load(file);
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
