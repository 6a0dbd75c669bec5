// SPDX-License-Identifier: Apache-2.0
// A config skeleton: the given components at their places, with what every parameter is said beside it.
#include "document/document.hpp"

#include <map>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/config.hpp"

namespace binnacle::document {

using Json = nlohmann::ordered_json;

namespace {

using Comments = std::map<std::string, std::string>;  // by JSON pointer

bool is_flat(const Json& json) {
  for (const Json& item : json) {
    if (item.is_structured() && !(item.is_array() && is_flat(item))) return false;
  }
  return true;
}

class Printer {
 public:
  explicit Printer(const Comments& comments) : comments_(comments) {}

  std::string print(const Json& json) {
    value(json, "", 0);
    return text_ + "\n";
  }

 private:
  void value(const Json& json, const std::string& pointer, std::size_t depth) {
    if (!json.is_structured() || json.empty() || (json.is_array() && is_flat(json))) {
      text_ += one_line(json);
      return;
    }
    text_ += json.is_object() ? "{\n" : "[\n";
    std::size_t i = 0;
    for (const auto& [key, item] : json.items()) {
      const std::string place = json.is_object() ? join_pointer(pointer, key) : join_pointer(pointer, i);
      text_ += std::string(2 * depth + 2, ' ') + (json.is_object() ? Json(key).dump() + ": " : "");
      const auto comment = comments_.find(place);
      const bool is_long = item.is_structured() && !item.empty() && !(item.is_array() && is_flat(item));
      value(item, place, depth + 1);
      if (++i < json.size()) text_ += ",";
      if (comment != comments_.end() && !is_long) text_ += "  // " + comment->second;
      text_ += "\n";
    }
    text_ += std::string(2 * depth, ' ') + (json.is_object() ? "}" : "]");
  }

  /// [1, 2] rather than [1,2].
  static std::string one_line(const Json& json) {
    if (!json.is_array()) return json.dump();
    std::string text;
    for (const Json& item : json) text += (text.empty() ? "" : ", ") + one_line(item);
    return "[" + text + "]";
  }

  const Comments& comments_;
  std::string text_;
};

/// A value that the parameter would take.
Json example(const ParameterSpec& spec) {
  if (!spec.default_json.empty() && spec.default_json[0] != '/') return Json::parse(spec.default_json, nullptr, false);
  switch (spec.type) {
    case ParameterType::boolean: return true;
    case ParameterType::text: return "";
    case ParameterType::choice: return spec.choices.empty() ? "" : spec.choices.front();
    case ParameterType::path: return "FILE";
    case ParameterType::list: return Json::array({example(spec.members.front())});
    case ParameterType::map: return {{"NAME", example(spec.members.front())}};
    case ParameterType::object: {
      Json members = Json::object();
      for (const ParameterSpec& member : spec.members)
        if (member.is_required) members[member.name] = example(member);
      return members;
    }
    default: return Json::parse(example_text(spec));
  }
}

class Skeleton {
 public:
  void add(const ComponentType& type) {
    switch (type.role) {
      case Role::state_block: add_block(type); return;
      case Role::derived_block: put(type, in_filter("derived"), ports(type)); return;
      case Role::process_model: add_process(type); return;
      case Role::measurement_model: add_measurement(type); return;
      case Role::noise_estimator: add_noise(type); return;
      case Role::source: put(type, "/sources", {}); return;
      case Role::transform: put(type, "/transforms", inputs(type)); return;
      case Role::sink: put(type, "/sinks", inputs(type)); return;
    }
  }

  std::string text() {
    Json ordered{{"binnacle", 1}};
    for (const char* section : {"sources", "transforms", "filters", "sinks"}) {
      if (root_.contains(section)) ordered[section] = root_[section];
    }
    return Printer(comments_).print(ordered);
  }

 private:
  static std::string in_filter(const std::string& section) { return "/filters/filter/" + section; }

  static Json ports(const ComponentType& type) {
    Json reserved = Json::object();
    for (const PortSpec& port : type.spec.ports) {
      if (!port.is_optional) reserved["blocks"][port.name] = "BLOCK";
    }
    return reserved;
  }

  static Json inputs(const ComponentType& type) {
    if (type.spec.inputs.size() == 1) return {{"input", "CHANNEL"}};
    return named_inputs(type);
  }

  static Json named_inputs(const ComponentType& type) {
    Json reserved = Json::object();
    for (const ChannelPort& input : type.spec.inputs) {
      if (!input.is_optional) reserved["inputs"][input.name] = "CHANNEL";
    }
    return reserved;
  }

  void add_block(const ComponentType& type) {
    const std::string place = put(type, in_filter("blocks"), {});
    Json& block = root_[Json::json_pointer(place)];
    if (!block.contains("init")) block["init"] = {{"channel", "CHANNEL"}};
    if (!block.contains("sigma")) block["sigma"] = 1;
    comments_.emplace(place + "/sigma", "initial standard deviation, one for all or by component");
  }

  void add_process(const ComponentType& type) {
    Json reserved = ports(type);
    if (!type.spec.fields.empty()) reserved["input"] = "CHANNEL";
    reserved.update(named_inputs(type));
    put(type, in_filter("process"), reserved);
  }

  void add_measurement(const ComponentType& type) {
    Json reserved{{"channel", "CHANNEL"}};
    reserved.update(ports(type));
    reserved.update(named_inputs(type));
    last_measurement_ = put(type, in_filter("measurements"), reserved);
  }

  void add_noise(const ComponentType& type) {
    if (last_measurement_.empty()) {
      last_measurement_ = in_filter("measurements") + "/measurement";
      root_[Json::json_pointer(last_measurement_)] = {{"type", "TYPE"}, {"channel", "CHANNEL"}};
    }
    const std::string place = last_measurement_ + "/noise";
    root_[Json::json_pointer(place)] = component(type, place, {});
  }

  /// Under the type's name, or with a number behind it where that is taken. Returns where.
  std::string put(const ComponentType& type, const std::string& section, const Json& reserved) {
    std::string place = section + "/" + type.spec.type;
    for (int i = 2; root_.contains(Json::json_pointer(place)); ++i) {
      place = section + "/" + type.spec.type + "_" + std::to_string(i);
    }
    root_[Json::json_pointer(place)] = component(type, place, reserved);
    return place;
  }

  Json component(const ComponentType& type, const std::string& place, const Json& reserved) {
    Json json{{"type", type.full_name()}};
    comments_[place + "/type"] = type.spec.summary;
    if (reserved.is_object()) json.update(reserved);
    for (const PortSpec& port : type.spec.ports)
      comments_[place + "/blocks/" + port.name] = port.kind + ": " + port.text;
    add_parameters(type.spec.parameters, place, json);
    const Json example = Json::parse(type.spec.example, nullptr, false, true);
    if (example.is_object()) json.update(example);
    const bool is_model = type.role == Role::process_model || type.role == Role::measurement_model;
    if (!is_model && json.contains("input")) json.erase("inputs");
    return json;
  }

  void add_parameters(const std::vector<ParameterSpec>& specs, const std::string& place, Json& json) {
    for (const ParameterSpec& spec : specs) {
      const std::string short_text = requirement_text(spec);
      comments_[join_pointer(place, spec.name)] = short_text + (spec.text.empty() ? "" : ": " + spec.text);
      if (!spec.is_required && (spec.default_json.empty() || spec.default_json[0] == '/')) continue;
      json[spec.name] = example(spec);
    }
  }

  Json root_ = Json::object();
  Comments comments_;
  std::string last_measurement_;
};

}  // namespace

std::string skeleton(const std::vector<const ComponentType*>& types) {
  Skeleton skeleton;
  for (const ComponentType* type : types) skeleton.add(*type);
  return skeleton.text();
}

}  // namespace binnacle::document
