// SPDX-License-Identifier: Apache-2.0
// list, describe, create, schema: what components there are.
#include <algorithm>

#include <fmt/format.h>

#include "binnacle/catalog.hpp"
#include "binnacle/diagnostic.hpp"
#include "document/document.hpp"
#include "output.hpp"
#include "reference.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

// ---- list

/// "state_block": a role's name as one word of a command line.
std::string role_word(Role role) {
  std::string word = role_name(role);
  std::replace(word.begin(), word.end(), ' ', '_');
  return word;
}

/// The whole name, or a word of it: "block" stands for the state block, the first that has the word.
Role role_called(const std::string& name) {
  std::string wanted = name;
  std::replace_if(
      wanted.begin(), wanted.end(), [](char c) { return c == ' ' || c == '-'; }, '_');
  std::vector<std::string> words;
  for (const Role role : all_roles) {
    words.push_back(role_word(role));
    if (words.back() == wanted) return role;
  }
  for (const Role role : all_roles) {
    const std::string word = "_" + role_word(role) + "_";
    if (word.find("_" + wanted + "_") != std::string::npos) return role;
  }
  for (const char* word : {"block", "process", "measurement", "derived", "noise"}) words.push_back(word);
  const std::string near = closest(wanted, words);
  words.resize(std::size(all_roles));
  throw UsageError(fmt::format("there is no role '{}'{} (roles: {})", name,
                               near.empty() ? "" : "; did you mean '" + near + "'?", joined(words)));
}

Json list_json(const std::vector<const ComponentType*>& types) {
  Json list = Json::array();
  for (const auto* type : types)
    list.push_back({{"name", type->full_name()},
                    {"role", role_name(type->role)},
                    {"plugin", type->plugin},
                    {"summary", type->spec.summary}});
  return list;
}

std::string list_text(const std::vector<const ComponentType*>& types) {
  std::string text;
  for (const Role role : all_roles) {
    Table table("ll");
    for (const auto* type : types)
      if (type->role == role) table.row({type->full_name(), type->spec.summary});
    if (!table.empty()) text += fmt::format("{}{}\n{}", text.empty() ? "" : "\n", role_name(role), table.text());
  }
  return text;
}

void list_plugins(const Catalog& catalog, bool json) {
  Json list = Json::array();
  Table table("lll", 0);
  for (const auto& plugin : catalog.plugins()) {
    list.push_back({{"name", plugin.name}, {"version", plugin.version}, {"file", plugin.file.string()}});
    table.row({plugin.name, plugin.version, plugin.file.string()});
  }
  if (json)
    print_json(list);
  else
    print(table.text());
}

struct ListOptions {
  std::string role;
  bool plugins = false;
  bool json = false;
};

int list(const ListOptions& options) {
  int status = ok;
  const Catalog catalog = load_catalog(status);
  if (options.plugins) {
    list_plugins(catalog, options.json);
    return status;
  }
  auto types = catalog.types();
  if (!options.role.empty()) {
    const Role role = role_called(options.role);
    std::erase_if(types, [role](const ComponentType* type) { return type->role != role; });
  }
  if (options.json)
    print_json(list_json(types));
  else
    print(list_text(types));
  return status;
}

// ---- describe, create

/// The type that was most likely meant, of any role; "" if none is near.
std::string nearest_type(const std::vector<const ComponentType*>& types, const std::string& name) {
  std::vector<std::string> names;
  for (const auto* type : types) {
    const auto& former = type->spec.former_names;
    if (std::find(former.begin(), former.end(), name) != former.end()) return type->full_name();
    names.push_back(name.find('/') != name.npos ? type->full_name() : type->spec.type);
  }
  return closest(name, names);
}

/// Those of any role that the name may mean.
std::vector<const ComponentType*> types_called(const Catalog& catalog, const std::string& name) {
  std::vector<const ComponentType*> types;
  for (const auto* type : catalog.types())
    if (type->spec.type == name || type->full_name() == name) types.push_back(type);
  if (!types.empty()) return types;
  const std::string near = nearest_type(catalog.types(), name);
  throw UsageError(
      fmt::format("there is no component type '{}'{}", name,
                  near.empty() ? "; `binnacle list` shows all of them" : fmt::format("; did you mean '{}'?", near)));
}

const ComponentType* type_called(const Catalog& catalog, const std::string& name) {
  const auto types = types_called(catalog, name);
  const auto of_its_own = std::ranges::find(types, name, &ComponentType::plugin);
  if (types.size() == 1) return types.front();
  if (of_its_own != types.end()) return *of_its_own;
  std::vector<std::string> names;
  for (const auto* type : types) names.push_back(fmt::format("'{}' ({})", type->full_name(), role_name(type->role)));
  throw UsageError(fmt::format("'{}' is ambiguous: {}", name, joined(names, " or ")));
}

struct TypeOptions {
  std::vector<std::string> types;
  bool all = false;
  bool json = false;
};

int describe_types(const TypeOptions& options) {
  int status = ok;
  const Catalog catalog = load_catalog(status);
  if (options.all == !options.types.empty()) throw UsageError("describe takes a TYPE, or --all");
  if (options.all && !options.json) {
    print(reference_page(catalog));
    return status;
  }
  std::string text;
  Json json = Json::array();
  if (options.all) {
    for (const auto* type : catalog.types()) json.push_back(document::describe_json(*type));
    print_json(json);
    return status;
  }
  for (const auto* type : types_called(catalog, options.types.front())) {
    text += (text.empty() ? "" : "\n") + document::describe(*type);
    json.push_back(document::describe_json(*type));
  }
  if (options.json)
    print_json(json.size() == 1 ? json.front() : json);
  else
    print(text);
  return status;
}

int create(const TypeOptions& options) {
  int status = ok;
  const Catalog catalog = load_catalog(status);
  std::vector<const ComponentType*> types;
  for (const auto& name : options.types) types.push_back(type_called(catalog, name));
  const std::string text = document::skeleton(types);
  if (options.json)
    print_json(Json::parse(text, nullptr, true, true));
  else
    print(text);
  return status;
}

}  // namespace

Verb list_verb(CLI::App& command) {
  const auto options = std::make_shared<ListOptions>();
  CLI::App* app = add_verb(command, "list");
  app->add_option("ROLE", options->role,
                  "List only one role: block, process, measurement, derived, noise, source, transform, sink");
  app->add_flag("--plugins", options->plugins, "List the plugins, with their versions and files");
  app->add_flag("--json", options->json, "As JSON");
  return {app, [options] { return list(*options); }};
}

Verb describe_verb(CLI::App& command) {
  const auto options = std::make_shared<TypeOptions>();
  CLI::App* app = add_verb(command, "describe");
  app->add_option("TYPE", options->types, "Component type, for example \"vector\" or \"core/vector\"")->expected(1);
  app->add_flag("--all", options->all, "Describe all types and the kernel's own keys, as one Markdown page");
  app->add_flag("--json", options->json, "Print JSON: an object, or an array if several types have the name");
  return {app, [options] { return describe_types(*options); }};
}

Verb create_verb(CLI::App& command) {
  const auto options = std::make_shared<TypeOptions>();
  CLI::App* app = add_verb(command, "create");
  app->add_option("TYPE", options->types, "Component type, for example \"vector\" or \"core/vector\"")->required();
  app->add_flag("--json", options->json, "Omit the comments");
  return {app, [options] { return create(*options); }};
}

Verb schema_verb(CLI::App& command) {
  CLI::App* app = add_verb(command, "schema");
  const auto json = std::make_shared<bool>(false);
  app->add_flag("--json", *json, "No effect: a schema is always JSON");
  return {app, [json] {
            int status = ok;
            const Catalog catalog = load_catalog(status);
            print_json(document::schema(catalog));
            return status;
          }};
}

}  // namespace binnacle::command
