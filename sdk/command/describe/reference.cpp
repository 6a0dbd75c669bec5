// SPDX-License-Identifier: Apache-2.0
#include "reference.hpp"

#include <cctype>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "document/document.hpp"

namespace binnacle::command {

namespace {

using Json = nlohmann::ordered_json;

/// The schema behind a reference and behind "unless it extends another"; a description nearer by counts.
struct Resolved {
  Json schema;
  std::string description;
};

Resolved resolve(const Json& root, Json schema) {
  std::string description = schema.value("description", "");
  while (true) {
    if (schema.contains("$ref")) {
      const std::string pointer = schema["$ref"].get<std::string>().substr(1);
      schema = Json(root.at(Json::json_pointer(pointer)));
    } else if (schema.contains("if") && schema.contains("else")) {
      schema = Json(schema["else"]);
    } else {
      break;
    }
    if (description.empty()) description = schema.value("description", "");
  }
  return {schema, description};
}

std::string key_table(const Json& root, const Json& object) {
  std::string text = "| key | |\n|---|---|\n";
  for (const auto& [key, schema] : object.at("properties").items())
    text += fmt::format("| `{}` | {} |\n", key, resolve(root, schema).description);
  return text + "\n";
}

/// As GitHub makes it of a heading.
std::string anchor(const std::string& heading) {
  std::string id;
  for (const char c : heading) {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-') id += static_cast<char>(std::tolower(c));
    if (c == ' ') id += '-';
  }
  return id;
}

std::string own_keys(const Catalog& catalog) {
  const Json root = document::schema(catalog);
  const auto definition = [&](const char* name) { return resolve(root, root.at("definitions").at(name)).schema; };
  const Json whole = root.at("else");
  Json block = Json::object();
  for (const char* key : {"init", "sigma", "estimate", "consider", "hold"})
    block["properties"][key] = {{"$ref", std::string("#/definitions/") + key}};
  std::string text =
      "## The config\n\nA JSON object; `//` and `/* */` comments are allowed.\n\n" + key_table(root, whole);
  text += "## A filter\n\n" + key_table(root, definition("filter"));
  text += "## Every state block\n\nBeside the parameters of its type:\n\n" + key_table(root, block);
  text += "## Every measurement\n\nBeside the parameters of its type, or with a `stack` of several:\n\n" +
          key_table(root, definition("stacked_measurement"));
  text += "## `reference`\n\n";
  const Json reference = definition("reference");
  for (const auto& alternative : reference.at("anyOf")) text += key_table(root, alternative);
  return text + "## `evaluate`\n\n" + key_table(root, whole.at("properties").at("evaluate"));
}

std::string plural(Role role) {
  std::string name = std::string(role_name(role)) + "s";
  name[0] = static_cast<char>(std::toupper(name[0]));
  return name;
}

}  // namespace

std::string reference_page(const Catalog& catalog) {
  std::string contents, components;
  for (const Role role : all_roles) {
    std::string entries;
    for (const auto* type : catalog.types()) {
      if (type->role != role) continue;
      contents += entries.empty() ? fmt::format("- [{0}](#{1}):", plural(role), anchor(plural(role))) : ",";
      contents += fmt::format(" [{}](#{})", type->spec.type, anchor(type->full_name()));
      entries += fmt::format("### {}\n\n```text\n{}```\n\n", type->full_name(), document::describe(*type));
    }
    if (entries.empty()) continue;
    contents += "\n";
    components += fmt::format("## {}\n\n{}", plural(role), entries);
  }
  std::string page =
      "# Config reference\n\nMade by `binnacle describe --all` from the specs that the plugins declare; "
      "do not edit it. Units: a number is SI, a string has its unit (`\"0.2 deg/h\"`).\n\n" +
      contents + "\n" + own_keys(catalog) + components;
  page.erase(page.find_last_not_of('\n') + 2);
  return page;
}

}  // namespace binnacle::command
