// SPDX-License-Identifier: Apache-2.0
// A component's documentation, made of its spec: text for people, JSON for programs.
#include "document/document.hpp"
#include "kind_name.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"

namespace binnacle::document {

using Json = nlohmann::ordered_json;

namespace {

const char* access_name(PortAccess access) { return access == PortAccess::advances ? "advances" : "reads"; }

const char* type_name(ParameterType type) {
  constexpr const char* names[] = {"number", "integer", "boolean", "text", "choice", "path",
                                   "vector", "matrix",  "time",    "list", "map",    "object"};
  return names[static_cast<std::size_t>(type)];
}

// ---- text

using Row = std::vector<std::string>;

/// Characters, not bytes: "Gauss–Markov" is as wide as it looks.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string table(const std::string& title, const std::vector<Row>& rows) {
  if (rows.empty()) return {};
  std::vector<std::size_t> widths;
  for (const Row& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  }
  std::string text = "\n" + title + "\n";
  for (const Row& row : rows) {
    std::string line = " ";
    for (std::size_t i = 0; i < row.size(); ++i)
      line += " " + row[i] + std::string(widths[i] - width_of(row[i]) + 1, ' ');
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string presence(const ParameterSpec& spec) {
  if (spec.is_required) return "required";
  return spec.default_json.empty() ? "optional" : "default " + spec.default_json;
}

void add_parameters(const std::vector<ParameterSpec>& specs, const std::string& prefix, std::vector<Row>& rows) {
  for (const ParameterSpec& spec : specs) {
    rows.push_back({prefix + spec.name, requirement_text(spec), presence(spec), spec.text});
    if (spec.type == ParameterType::object) add_parameters(spec.members, prefix + spec.name + ".", rows);
    if ((spec.type != ParameterType::list && spec.type != ParameterType::map) || spec.members.empty()) continue;
    const ParameterSpec& element = spec.members.front();
    const std::string place = prefix + spec.name + (spec.type == ParameterType::list ? "[]" : ".*");
    if (element.type == ParameterType::object) {
      add_parameters(element.members, place + ".", rows);
    } else {
      rows.push_back({place, requirement_text(element), "", element.text});
    }
  }
}

std::vector<Row> field_rows(const std::vector<FieldSpec>& fields) {
  std::vector<Row> rows;
  for (const FieldSpec& field : fields) {
    std::string kind = kind_name(field.kind);
    if (field.is_per_row) kind += " per row";
    rows.push_back({field.name, field.unit, kind, field.is_optional ? "optional" : "required", field.text});
  }
  return rows;
}

const char* fields_title(Role role) {
  return role == Role::process_model ? "Fields of its input" : "Fields of its channel";
}

}  // namespace

std::string describe(const ComponentType& type) {
  const ComponentSpec& spec = type.spec;
  std::string text =
      type.full_name() + ": " + role_name(type.role) + " (plugin " + type.plugin + " " + type.plugin_version + ")\n";
  if (!spec.summary.empty()) text += "  " + spec.summary + "\n";
  if (!spec.source.empty()) text += "  Source: " + spec.source + "\n";
  if (!spec.kind.empty()) text += "  Kind: " + spec.kind + "\n";
  std::vector<Row> ports;
  for (const PortSpec& port : spec.ports) {
    ports.push_back(
        {port.name, port.kind, access_name(port.access), port.is_optional ? "optional" : "required", port.text});
  }
  text += table("Ports (\"blocks\")", ports);
  text += table(fields_title(type.role), field_rows(spec.fields));
  text += table("Mean rates of the driving input", field_rows(spec.driving_rates));
  for (const ChannelPort& input : spec.inputs) {
    const bool is_model = type.role == Role::process_model || type.role == Role::measurement_model;
    const std::string title = (is_model ? "Auxiliary channel '" : "Input '") + input.name + "'" +
                              (input.is_optional ? " (optional)" : "") + (input.text.empty() ? "" : ": " + input.text);
    const std::vector<Row> rows = input.is_whole ? std::vector<Row>() : field_rows(input.fields);
    text += rows.empty() ? "\n" + title + "\n" : table(title, rows);
  }
  std::vector<Row> parameters;
  add_parameters(spec.parameters, "", parameters);
  text += table("Parameters", parameters);
  if (!spec.example.empty()) text += "\nExample\n  " + spec.example + "\n";
  return text;
}

// ---- JSON

namespace {

Json parameter_json(const ParameterSpec& spec) {
  Json json{{"name", spec.name}, {"type", type_name(spec.type)}};
  if (!spec.unit.empty()) json["unit"] = spec.unit;
  json["required"] = spec.is_required;
  if (spec.default_json.starts_with('/'))
    json["default_at"] = spec.default_json;
  else if (!spec.default_json.empty())
    json["default"] = Json::parse(spec.default_json, nullptr, false);
  if (std::isfinite(spec.minimum)) json[spec.minimum_excluded ? "above" : "at_least"] = spec.minimum;
  if (std::isfinite(spec.maximum)) json[spec.maximum_excluded ? "below" : "at_most"] = spec.maximum;
  if (spec.size != ParameterSpec::any_size) json["size"] = spec.size;
  if (spec.cols != ParameterSpec::any_size) json["cols"] = spec.cols;
  if (!spec.size_of_port.empty()) json["size_of_port"] = spec.size_of_port;
  if (!spec.choices.empty()) json["choices"] = spec.choices;
  for (const ParameterSpec& member : spec.members) json["members"].push_back(parameter_json(member));
  json["text"] = spec.text;
  return json;
}

Json fields_json(const std::vector<FieldSpec>& fields) {
  Json list = Json::array();
  for (const FieldSpec& field : fields) {
    list.push_back({{"name", field.name},
                    {"unit", field.unit},
                    {"kind", kind_name(field.kind)},
                    {"required", !field.is_optional},
                    {"per_row", field.is_per_row},
                    {"text", field.text}});
  }
  return list;
}

}  // namespace

Json describe_json(const ComponentType& type) {
  const ComponentSpec& spec = type.spec;
  Json json{{"name", type.full_name()},       {"role", role_name(type.role)}, {"plugin", type.plugin},
            {"version", type.plugin_version}, {"summary", spec.summary},      {"source", spec.source}};
  if (!spec.kind.empty()) json["kind"] = spec.kind;
  json["parameters"] = Json::array();
  for (const ParameterSpec& parameter : spec.parameters) json["parameters"].push_back(parameter_json(parameter));
  json["ports"] = Json::array();
  for (const PortSpec& port : spec.ports) {
    json["ports"].push_back({{"name", port.name},
                             {"kind", port.kind},
                             {"access", access_name(port.access)},
                             {"required", !port.is_optional},
                             {"text", port.text}});
  }
  json["fields"] = fields_json(spec.fields);
  json["driving_rates"] = fields_json(spec.driving_rates);
  json["inputs"] = Json::array();
  for (const ChannelPort& input : spec.inputs) {
    json["inputs"].push_back({{"name", input.name},
                              {"required", !input.is_optional},
                              {"text", input.text},
                              {"fields", input.is_whole ? Json("all") : fields_json(input.fields)}});
  }
  if (!spec.example.empty()) json["example"] = Json::parse(spec.example, nullptr, false, true);
  if (json.contains("example") && json["example"].is_discarded()) json["example"] = spec.example;
  return json;
}

}  // namespace binnacle::document
