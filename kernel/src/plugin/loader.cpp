// SPDX-License-Identifier: Apache-2.0
// Loading one plugin file, and the library boundary at which what a plugin throws is caught.
#include "plugin/loader.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <exception>
#include <set>
#include <string>
#include <utility>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/shared_library.hpp>

#include "plugin/guard.hpp"
#include "plugin/library_file.hpp"
#include "spec/check.hpp"

namespace binnacle::plugin {

/// Collects what a plugin registers.
class PluginRegistry final : public Registry {
 public:
  PluginRegistry(const PluginInfo& info, std::shared_ptr<const void> library)
      : info_(info), library_(std::move(library)) {}

  std::vector<ComponentType> types;

 protected:
  void add_component(Role role, ComponentSpec spec, AnyFactory factory) override {
    ComponentType& type = types.emplace_back();
    type.role = role;
    type.spec = std::move(spec);
    type.plugin = info_.name;
    type.plugin_version = info_.version;
    type.file = info_.file;
    type.factory_ = factory;
    type.library_ = library_;
  }

 private:
  const PluginInfo& info_;
  std::shared_ptr<const void> library_;
};

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

/// What is wrong with a file, all at its place.
class Report {
 public:
  Report(const std::filesystem::path& file, Diagnostics& diagnostics) : place_{file.string(), 0, 0}, to_(diagnostics) {}

  void warn(const char* code, std::string text) { to_.warning(code, place_, "", std::move(text)); }
  /// False, for whoever returns it.
  bool refuse(const char* code, std::string text) {
    to_.error(code, place_, "", std::move(text));
    return false;
  }

 private:
  Origin place_;
  Diagnostics& to_;
};

bool check_file(const std::filesystem::path& file, Report& report) {
  struct ::stat status {};
  if (::stat(file.c_str(), &status) != 0)
    return report.refuse("B040", std::string("the plugin cannot be opened: ") + std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return report.refuse("B040", "the plugin is not a file");
  if (status.st_mode & S_IWOTH)
    return report.refuse("B044", "the plugin file is world-writable, so it is not loaded; chmod o-w it");
  return true;
}

bool check_exports(const LibraryFile& library, Report& report) {
  const auto no_plugin = [&](const std::string& why) {
    return report.refuse("B041", "not a plugin for this program: " + why);
  };
  if (!library.unreadable.empty()) return no_plugin(library.unreadable);
  if (!library.guard && !library.other_guard.empty())
    return no_plugin("it is one for another major version (exports " + library.other_guard + ", not " + guard_symbol +
                     ")");
  if (!library.guard) return no_plugin(std::string("it exports no ") + guard_symbol);
  if (!library.has_register) return no_plugin(std::string("it exports no ") + register_symbol);
  return true;
}

bool check_guard(const abi::Guard& guard, Report& report) {
  bool is_accepted = true;
  for (const auto& difference : abi::compare(abi::guard_of_host(), guard, abi::processor_instruction_sets())) {
    if (difference.severity == abi::Severity::refused)
      is_accepted = report.refuse("B042", abi::to_string(difference));
    else
      report.warn("B043", abi::to_string(difference));
  }
  return is_accepted;
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

bool check_types(const PluginInfo& info, const std::vector<ComponentType>& types, Report& report) {
  bool is_good = true;
  std::set<std::string> seen;
  for (const ComponentType& type : types) {
    const ComponentSpec& spec = type.spec;
    const std::string who = "plugin '" + info.name + "', component '" + spec.type + "': ";
    if (!is_name(spec.type)) is_good = report.refuse("B045", who + "its type is no name in snake_case");
    for (const std::string& defect : spec::spec_defects(spec)) is_good = report.refuse("B045", who + defect);
    if (!seen.insert(spec.type).second)
      is_good = report.refuse("B046", "plugin '" + info.name + "' registers '" + spec.type + "' twice");
  }
  return is_good;
}

}  // namespace

std::optional<LoadedPlugin> load_plugin(const std::filesystem::path& file, Diagnostics& diagnostics,
                                        const std::function<bool(const PluginInfo&)>& accept) {
  Report report(file, diagnostics);
  if (!check_file(file, report)) return std::nullopt;
  const LibraryFile inspected = inspect_library(file);
  if (!check_exports(inspected, report) || !check_guard(*inspected.guard, report)) return std::nullopt;
  const PluginInfo info{abi::text_of(inspected.guard->name), abi::text_of(inspected.guard->version), file};
  if (!is_name(info.name)) {
    report.refuse("B045", "the plugin's name '" + info.name + "' is not in snake_case");
    return std::nullopt;
  }
  if (!accept(info)) return std::nullopt;
  CallSite site;
  const std::string itself;
  site.enter(&info.name, itself, "loading it");
  const CallScope scope(site);
  std::shared_ptr<boost::dll::shared_library> library;
  try {
    using namespace boost::dll;
    library = std::make_shared<shared_library>(file, load_mode::rtld_now | load_mode::rtld_local);
  } catch (const std::exception& error) {
    report.refuse("B045", "the plugin cannot be loaded: " + loader_message(error.what()));
    return std::nullopt;
  }
  PluginRegistry registry(info, library);
  try {
    library->get<void(Registry&)>(register_symbol)(registry);
  } catch (...) {
    // The message is made inside the handler and the exception gone at its end, before the library may be.
    report.refuse("B045", "plugin '" + info.name + "': " + register_symbol + " threw: " + what_was_thrown());
    return std::nullopt;
  }
  if (!check_types(info, registry.types, report)) return std::nullopt;
  return LoadedPlugin{info, std::move(registry.types)};
}

}  // namespace binnacle::plugin

namespace binnacle {

void ComponentType::rethrow_as_component_error(const CallSite& site) {
  // Copies: the plugin's own exception object may not outlive its library.
  std::string message;
  try {
    throw;
  } catch (const ComponentError& error) {
    ComponentError copy = error;
    throw copy;
  } catch (...) {
    message = site.text() + " threw: " + plugin::what_was_thrown();
  }
  throw ComponentError(message);
}

}  // namespace binnacle
