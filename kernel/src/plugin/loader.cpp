// SPDX-License-Identifier: Apache-2.0
// Loading one plugin file, and the library boundary at which what a plugin throws is caught.
#include <dlfcn.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

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

/// Where a library is opened that has passed. The loader knows a library by the name that it was opened under, so the file
/// stays open for good, lest another get its number; debuggers open that name too, hence the number of this process in it.
std::string name_for_good(OpenFile& file) {
  static std::mutex mutex;
  static auto& files = *new std::map<std::pair<dev_t, ino_t>, int>;
  const std::lock_guard lock(mutex);
  const auto [kept, is_new] = files.try_emplace({file.status.st_dev, file.status.st_ino}, file.id);
  if (is_new) file.id = -1;
  std::error_code error;
  return "/proc/" + fs::read_symlink("/proc/self", error).string() + "/fd/" + std::to_string(kept->second);
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
  Examination(const fs::path& file, FolderLook& look, Diagnostics& diagnostics)
      : file_(file), look_(look), diagnostics_(diagnostics) {
    info_.file = file;
  }

  std::optional<PluginInfo> outcome(Others others) {
    if (!check_file()) return std::nullopt;
    const LibraryFile library = inspect_library(file_);
    if (!check_exports(library) || !check_guard(*library.guard)) return std::nullopt;
    info_.name = abi::text_of(library.guard->name);
    info_.version = abi::text_of(library.guard->version);
    info_.listed = words(library.types);
    looks_beside_ = library.looks_beside;
    return check_name(info_, others, diagnostics_) ? std::optional(info_) : std::nullopt;
  }
  /// A library that looks for others beside itself has to be opened there.
  std::string loadable_name() { return looks_beside_ ? info_.file.string() : name_for_good(file_); }

 private:
  bool check_file() {
    const auto no_file = [&](const std::string& why) {
      return refuse(diagnostics_, info_, "B040", "the plugin " + why);
    };
    if (!file_.failure.empty()) return no_file("cannot be opened: " + file_.failure);
    if (!S_ISREG(file_.status.st_mode)) return no_file("is not a file");
    const std::string text = exposure(file_, info_.file, look_);
    return text.empty() || refuse(diagnostics_, info_, "B044", text);
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

  OpenFile file_;
  FolderLook& look_;
  PluginInfo info_;
  bool looks_beside_ = false;
  Diagnostics& diagnostics_;
};

}  // namespace

/// Loads a file and collects what it registers. What is wrong with it goes to the diagnostics, all at its place; checks
/// say whether it is good.
class PluginRegistry final : public Registry {
 public:
  PluginRegistry(std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types, Diagnostics& diagnostics)
      : plugins_(plugins), all_types_(types), diagnostics_(diagnostics) {}

  bool load(const PluginInfo& plugin, Examination& examination) {
    info_ = plugin;
    return take_types(register_symbol, [&] {
      const std::string name = examination.loadable_name();
      void* const library = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
      if (!library) {
        const std::string why = ::dlerror();
        throw std::runtime_error(why.starts_with(name + ": ") ? why.substr(name.size() + 2) : why);
      }
      library_ = std::shared_ptr<void>(library, ::dlclose);
      return reinterpret_cast<void (*)(Registry&)>(::dlsym(library, register_symbol));
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
      return refuse(diagnostics_, info_, "B045", std::string("the plugin cannot be loaded: ") + error.what());
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
      if (!is_name(spec.type)) is_good = refuse(diagnostics_, info_, "B045", who + "its type is not in snake_case");
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
  FolderLook look;
  return Examination(file, look, diagnostics).outcome(others);
}

void take_plugin(const fs::path& file, FolderLook& look, bool may_wait, std::vector<PluginInfo>& waiting,
                 std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types, Diagnostics& diagnostics) {
  Examination examination(file, look, diagnostics);
  const auto plugin = examination.outcome({&plugins, &waiting});
  if (plugin && may_wait && !plugin->listed.empty())
    waiting.push_back(*plugin);
  else if (plugin)
    PluginRegistry(plugins, types, diagnostics).load(*plugin, examination);
}

void load_waiting_plugin(const PluginInfo& plugin, std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types,
                         Diagnostics& diagnostics) {
  Diagnostics found;  // warnings were given before
  FolderLook look;
  Examination examination(plugin.file, look, found);
  const auto now = examination.outcome({});
  if (!now)
    diagnostics.merge(found);
  else if (now->name != plugin.name || now->version != plugin.version || now->listed != plugin.listed)
    refuse(diagnostics, plugin, "B045", "the plugin was exchanged while it was being loaded; start again");
  else
    PluginRegistry(plugins, types, diagnostics).load(plugin, examination);
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
