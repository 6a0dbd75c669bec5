// SPDX-License-Identifier: Apache-2.0
#include "miniature.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

namespace binnacle::conform {

namespace {

std::string word(FieldKind kind) {
  return kind == FieldKind::rate ? "rate" : kind == FieldKind::increment ? "increment" : "level";
}

/// A unit that can stand in a config: of what is left open, metres.
std::string concrete(const std::string& unit) {
  return unit.empty() || unit.find_first_of("*@") < unit.size() ? "1" : unit;
}

std::vector<std::string> parts_of(const std::string& kind) {
  std::vector<std::string> parts;
  std::istringstream in(kind);
  for (std::string part; std::getline(in, part, ':');) parts.push_back(part);
  return parts;
}

class Builder {
 public:
  Builder(const Trial& trial, const ComponentType& type, const Catalog& catalog, const Json& settings)
      : trial_(trial), type_(type), catalog_(catalog), settings_(settings), around_(Json::object()) {
    if (!type.spec.surroundings.empty()) around_ = Json::parse(type.spec.surroundings, nullptr, true, true);
    config_ = {{"binnacle", 1}};
    if (!trial.library.empty()) config_["plugins"] = Json::array({trial.library.string()});
    for (const auto& section : {"sources", "transforms", "filters"}) config_[section] = Json::object();
    if (around_.contains("sources")) config_["sources"] = around_.at("sources");
    for (const char* key : {"channel", "input"})
      if (settings_.contains(key)) flatten(settings_[key]);
    if (settings_.contains("inputs"))
      for (auto& input : settings_["inputs"]) flatten(input);
  }

  Json build() {
    write_files();
    Json subject = {{"type", type_.full_name()}};
    subject.update(settings_);
    switch (type_.role) {
      case Role::state_block: blocks()[component_name] = subject; break;
      case Role::process_model:
        plug_ports();
        filter()["process"][component_name] = subject;
        feed("input", type_.spec.fields);
        feed_inputs();
        break;
      case Role::measurement_model:
        plug_ports();
        feed("channel", type_.spec.fields);
        feed_inputs();
        drive();
        filter()["measurements"][component_name] = subject;
        break;
      case Role::derived_block:
        plug_ports();
        drive();
        filter()["derived"][component_name] = subject;
        break;
      case Role::noise_estimator: add_adapted_measurement(subject); break;
      case Role::source: config_["sources"][component_name] = subject; break;
      case Role::transform:
        feed_inputs();
        config_["transforms"][component_name] = subject;
        break;
      case Role::sink:
        feed_inputs();
        config_["sinks"][component_name] = subject;
        break;
    }
    if (config_["filters"].empty())
      blocks()["idle"] = {{"type", "core/vector"}, {"size", 1}, {"unit", "m"}, {"sigma", 1}};
    hold_the_rest();
    for (const auto& section : {"sources", "transforms", "filters"})
      if (config_[section].empty()) config_.erase(section);
    return config_;
  }

 private:
  /// A pushed source has one channel, of its own name: "ship.imu" becomes "ship_imu".
  void flatten(Json& channel) const {
    if (!channel.is_string() ||
        config_.at("sources").contains(channel.get<std::string>().substr(0, channel.get<std::string>().find('.'))))
      return;
    std::string name = channel.get<std::string>();
    std::replace(name.begin(), name.end(), '.', '_');
    channel = name;
  }

  Json& filter() { return config_["filters"][filter_name]; }
  Json& blocks() { return filter()["blocks"]; }

  /// {"hex": "b562…"}: what is no text.
  static std::string bytes_of(const Json& content) {
    const std::string digits = content.at("hex").get<std::string>();
    std::string bytes;
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
      bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
    return bytes;
  }

  void write_files() {
    if (!around_.contains("files")) return;
    for (const auto& [name, content] : around_.at("files").items()) {
      const std::filesystem::path file = trial_.scratch / name;
      std::filesystem::create_directories(file.parent_path());
      std::ofstream(file, std::ios::binary) << (content.is_string() ? content.get<std::string>() : bytes_of(content));
    }
  }

  /// A block of the kind that a port wants.
  Json block_of(const std::string& kind) const {
    const std::vector<std::string> parts = parts_of(kind);
    if (parts.empty() || parts[0] == "vector" || parts[0] == "*") {
      const int size = parts.size() > 1 && parts[1] != "*" ? std::stoi(parts[1]) : 2;
      return {{"type", "core/vector"},
              {"size", size},
              {"unit", parts.size() > 2 ? concrete(parts[2]) : "m"},
              {"sigma", 1}};
    }
    for (const bool own : {true, false})
      for (const auto* type : catalog_.types())
        if (type->role == Role::state_block && type->spec.kind == kind && (type->plugin == type_.plugin) == own) {
          Json block = {{"type", type->full_name()}};
          block.update(example_of(type->spec));
          return block;
        }
    Trial::skip("no block of the kind '" + kind + "' is to be found; name one in the spec's surroundings");
  }

  void plug(const ComponentSpec& spec, const Json& settings) {
    if (!settings.contains("blocks")) return;
    for (const auto& [port, name] : settings.at("blocks").items()) {
      const auto found = std::find_if(spec.ports.begin(), spec.ports.end(),
                                      [&, &port = port](const auto& p) { return p.name == port; });
      if (found == spec.ports.end() || !name.is_string()) continue;  // the composition will say so
      const std::string block = name.get<std::string>();
      if (found->access == PortAccess::advances) advanced_.insert(block);
      if (blocks().contains(block)) continue;
      const bool is_told = around_.contains("blocks") && around_.at("blocks").contains(block);
      blocks()[block] = is_told ? around_.at("blocks").at(block) : block_of(found->kind);
    }
  }
  void plug_ports() { plug(type_.spec, settings_); }

  void add_channel(const std::string& name, const std::vector<FieldSpec>& fields, const Json& renamed) {
    if (config_["sources"].contains(name.substr(0, name.find('.')))) return;
    Json declared = Json::object();
    int rows = 0;
    for (const auto& field : fields) {
      Json entry = {{"unit", concrete(field.unit)}, {"kind", word(field.kind)}};
      if (field.is_per_row) entry["per_row"] = true, rows = 4;
      const std::string as = renamed.is_object() && renamed.contains(field.name) && renamed.at(field.name).is_string()
                                 ? renamed.at(field.name).get<std::string>()
                                 : field.name;
      // An optional field that the example does not name stays away: most are a noise that comes with the data.
      if (field.is_optional && as == field.name && !(renamed.is_object() && renamed.contains(field.name)) &&
          !all_optional(fields))
        continue;
      declared[as] = entry;
    }
    Json source = {{"type", "core/pushed"}, {"fields", declared}};
    if (rows > 0) source["max_rows"] = rows;
    config_["sources"][name] = source;
  }
  static bool all_optional(const std::vector<FieldSpec>& fields) {
    return std::all_of(fields.begin(), fields.end(), [](const auto& f) { return f.is_optional; });
  }

  /// The channel that stands under `key` in the example carries what the spec wants of it.
  void feed(const char* key, const std::vector<FieldSpec>& fields) {
    if (settings_.contains(key) && settings_.at(key).is_string())
      add_channel(settings_.at(key).get<std::string>(), fields, settings_.value("fields", Json::object()));
  }
  void feed_inputs() {
    for (const auto& input : type_.spec.inputs) {
      std::string channel;
      if (settings_.contains("inputs") && settings_.at("inputs").contains(input.name))
        channel = settings_.at("inputs").at(input.name).get<std::string>();
      else if (settings_.contains("input") && settings_.at("input").is_string())
        channel = settings_.at("input").get<std::string>();
      if (channel.empty()) continue;
      const Json renamed = settings_.value("fields", Json::object());
      add_channel(channel, input.fields,
                  renamed.contains(input.name) && renamed.at(input.name).is_object() ? renamed.at(input.name)
                                                                                     : renamed);
    }
  }

  /// Rates that a component wants are those of the filter's driving input, so some process must have one.
  void drive() {
    if (type_.spec.driving_rates.empty()) return;
    for (const auto* type : catalog_.types()) {
      if (type->role != Role::process_model || type->spec.fields.empty() || type->spec.example.empty()) continue;
      const auto carries = [&](const FieldSpec& wanted) {
        return std::any_of(type->spec.fields.begin(), type->spec.fields.end(),
                           [&](const FieldSpec& field) { return field.name == wanted.name; });
      };
      if (!std::all_of(type_.spec.driving_rates.begin(), type_.spec.driving_rates.end(), carries)) continue;
      Json driver = {{"type", type->full_name()}};
      driver.update(example_of(type->spec));
      plug(type->spec, driver);
      add_channel(driver.at("input").get<std::string>(), type->spec.fields, Json::object());
      filter()["process"]["driver"] = driver;
      return;
    }
    Trial::skip("no process model with the driving input that it wants is to be found");
  }

  void add_adapted_measurement(const Json& estimator) {
    blocks()["state"] = {{"type", "core/vector"}, {"size", 2}, {"unit", "m"}, {"sigma", 1}};
    config_["sources"]["seen"] = {{"type", "core/pushed"},
                                  {"fields", {{"z0", {{"unit", "m"}}}, {"z1", {{"unit", "m"}}}}}};
    filter()["measurements"]["adapted"] = {{"type", "core/linear_measurement"},
                                           {"channel", "seen"},
                                           {"blocks", {{"x", "state"}}},
                                           {"sigma", Json::array({2, 3})},
                                           {"noise", estimator}};
  }

  /// Blocks that nobody moves stay as they are.
  void hold_the_rest() {
    if (!config_["filters"].contains(filter_name)) return;
    std::vector<std::string> names;
    for (const auto& block : blocks().items()) names.push_back(block.key());
    for (const auto& name : names) {
      if (advanced_.contains(name)) continue;
      filter()["process"]["hold_" + name] = {{"type", "core/random_constant"}, {"blocks", {{"x", name}}}};
    }
  }

  const Trial& trial_;
  const ComponentType& type_;
  const Catalog& catalog_;
  Json settings_;
  Json around_;
  Json config_;
  std::set<std::string> advanced_;
};

}  // namespace

Catalog load_catalog(const Trial& trial) {
  Catalog catalog;
  Diagnostics diagnostics;
  for (const auto& plugin : trial.options.linked_plugins) catalog.add(plugin, diagnostics);
  std::vector<PluginPath> libraries;
  if (!trial.library.empty()) libraries.push_back({trial.library, {}, "/plugins/0"});
  catalog.load_search_path(libraries, diagnostics, trial.options.plugin_folders);
  if (diagnostics.has_errors()) throw LoadError(diagnostics);
  return catalog;
}

const ComponentType& component(const Trial& trial, const Catalog& catalog) {
  if (const ComponentType* type = catalog.find(trial.role, trial.type)) return *type;
  throw std::out_of_range("the library has no component '" + trial.type + "'");
}

Json example_of(const ComponentSpec& spec) {
  if (spec.example.empty()) Trial::skip("'" + spec.type + "' has no example");
  const Json example = Json::parse(spec.example, nullptr, false, true);
  if (!example.is_object()) throw std::runtime_error("the example of '" + spec.type + "' is not a JSON object");
  return example;
}

Json miniature(const Trial& trial, const ComponentType& type, const Catalog& catalog, const Json& settings) {
  return Builder(trial, type, catalog, settings).build();
}

std::string component_pointer(Role role) {
  const std::string filter = std::string("/filters/") + filter_name;
  switch (role) {
    case Role::state_block: return filter + "/blocks/" + component_name;
    case Role::process_model: return filter + "/process/" + component_name;
    case Role::measurement_model: return filter + "/measurements/" + component_name;
    case Role::derived_block: return filter + "/derived/" + component_name;
    case Role::noise_estimator: return filter + "/measurements/adapted/noise";
    case Role::source: return std::string("/sources/") + component_name;
    case Role::transform: return std::string("/transforms/") + component_name;
    case Role::sink: return std::string("/sinks/") + component_name;
  }
  return "";
}

std::shared_ptr<const Composition> compose(const Trial& trial, const Json& config) {
  LoadOptions options = trial.options;
  // Named by the user, not by a config.
  if (const auto library = config.find("plugins"); library != config.end())
    options.sets.push_back("/plugins=" + library->dump());
  return Composition::parse(config.dump(), trial.scratch / "miniature.json", options);
}

std::shared_ptr<const Composition> compose_example(const Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  return compose(trial, miniature(trial, type, catalog, example_of(type.spec)));
}

}  // namespace binnacle::conform
