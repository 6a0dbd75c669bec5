// SPDX-License-Identifier: Apache-2.0
// The config as one JSON document.
#include "config/document.hpp"

#include <algorithm>
#include <utility>

#include "base/hash.hpp"
#include "base/text.hpp"
#include "config/node.hpp"

namespace binnacle::internal::config {

namespace fs = std::filesystem;

namespace {

const Origin set_option{"--set", 0, 0};

using base::in_quotes;

/// Gives a place its value, or deletes it for null. What is wrong with that, or "".
std::string assign(Node& root, const Tokens& tokens, Node value) {
  const bool erase = value.json.is_null();
  Node* parent = nullptr;
  Member* child = nullptr;
  std::string at;
  for (const std::string& token : tokens) {
    parent = child ? &child->value : &root;
    const bool is_list = parent->json.is_array();
    if (!parent->json.is_structured()) return in_quotes(at) + " is " + kind_name(*parent) + ", not an object or list";
    child = parent->find(token);
    if (!child && !erase && (!is_list || token == "-")) {
      const std::string key = is_list ? std::to_string(parent->children.size()) : token;
      parent->children.push_back({key, set_option, {Json::object(), set_option, parent->folder}});
      child = &parent->children.back();
    }
    if (!child && is_list)
      return in_quotes(at) + " is a list of " + std::to_string(parent->children.size()) + "; " + in_quotes(token) +
             " is not one of its indices (which start at 0" + (erase ? ")" : "; '-' appends)");
    if (!child) {
      const std::string meant = closest(token, parent->keys());
      return "there is nothing to delete" +
             (meant.empty() ? "" : "; did you mean " + in_quotes(join_pointer(at, meant)) + "?");
    }
    at = join_pointer(at, token);
  }
  if (erase)
    parent->erase(tokens.back());
  else
    *child = {child->key, set_option, std::move(value)};
  return "";
}

/// `--set /pointer=value`. The value is read as JSON, else it is a text; null deletes; a last token `-` appends to a
/// list. Objects on the way are made where they are missing.
void apply_setting(Node& root, const std::string& setting, const Folder& folder, Diagnostics& diagnostics) {
  const std::size_t equals = setting.find('=');
  const std::string pointer = setting.substr(0, equals);
  const bool is_absolute = pointer.starts_with('/');
  const auto report = [&](const std::string& message) {
    diagnostics.error("B029", set_option, is_absolute ? pointer : "", message);
  };
  if (!is_utf8(setting)) return report("--set is not UTF-8");
  if (equals == std::string::npos) return report(in_quotes(setting) + " is not of the form /pointer=value");
  if (!is_absolute)
    return report(in_quotes(pointer) + " is not a JSON pointer; did you mean " + in_quotes("/" + pointer) + "?");
  const auto tokens = split_pointer(pointer);
  if (!tokens) return report("a '~' in a JSON pointer is written '~0', a '/' inside a key '~1'");
  if (tokens->back() == "extends") return report("extends cannot be set; it is resolved before --set");
  const std::string text = setting.substr(equals + 1);
  std::optional<Node> value = read_json_value(text, set_option.file, folder);
  const bool looks_like_json = text.starts_with('{') || text.starts_with('[') || text.starts_with('"');
  if (!value && looks_like_json) return report(in_quotes(text) + " begins like JSON but is not");
  if (!value) value = Node{text, set_option, folder};
  const std::string problem = assign(root, *tokens, *std::move(value));
  if (!problem.empty()) report(problem);
}

bool is_inside_one_of(const std::string& setting, const std::vector<std::string>& patches) {
  const std::string pointer = setting.substr(0, setting.find('='));
  return std::ranges::any_of(patches, [&](const std::string& patch) {
    return pointer == patch || pointer.starts_with(patch + "/");
  });
}

void apply_patch(Node& root, const std::string& pointer, Diagnostics& diagnostics) {
  const Node* patch = &root;
  const auto tokens = split_pointer(pointer);
  for (std::size_t i = 0; patch && tokens && i < tokens->size(); ++i) {
    const Member* member = patch->find((*tokens)[i]);
    patch = member ? &member->value : nullptr;
  }
  if (!tokens || !patch || !patch->json.is_object()) {
    diagnostics.error("B029", root.origin, pointer, "there is no object here to be merged over the config");
    return;
  }
  Node copy = *patch;
  copy.origin = root.origin;
  copy.folder = root.folder;
  merge_patch(root, std::move(copy));
}

}  // namespace

Document Document::load(const fs::path& path, const LoadOptions& options, Diagnostics& diagnostics,
                        std::optional<std::string_view> text) {
  Document document;
  if (!text && options.text) text = *options.text;
  std::optional<Node> root = resolve_extends(path, text, diagnostics);
  if (root && pointer_bytes(*root) > most_pointers) {
    diagnostics.error(too_large, root->origin, "", pointers_too_long);
    root.reset();
  }
  if (!root) return document;
  std::vector<Tokens> patches;
  for (const auto& section : options.sections)
    for (const auto& place : section->patches())
      if (auto tokens = split_pointer(place); tokens && !tokens->empty()) patches.push_back(*std::move(tokens));
  drop_nulls(*root, patches);
  const auto current_folder = std::make_shared<const fs::path>(fs::current_path());
  const auto set = [&](bool wants_inside_a_patch) {
    for (const std::string& setting : options.sets)
      if (is_inside_one_of(setting, options.patches) == wants_inside_a_patch)
        apply_setting(*root, setting, current_folder, diagnostics);
  };
  set(true);
  for (const std::string& pointer : options.patches) apply_patch(*root, pointer, diagnostics);
  drop_nulls(*root, patches);
  document.is_patched_ = !options.patches.empty();
  set(false);
  drop_nulls(*root, patches);
  fill_in_variables(*root, options.vars, current_folder, diagnostics);
  const auto json = std::make_shared<Json>();
  document.take(*root, root->origin, "", *json);
  document.root_ = json;
  return document;
}

void Document::take(const Node& node, const Origin& key, const std::string& pointer, Json& json) {
  places_[pointer] = {node.origin, key, node.folder ? *node.folder : fs::path(), &json};
  json = node.json;
  if (node.children.empty()) return;
  // All are made before the first is filled, and stay where they are. Keys are there once: none is looked for.
  if (json.is_array()) {
    json.get_ref<Json::array_t&>().resize(node.children.size());
  } else {
    auto& members = json.get_ref<Json::object_t&>();
    members.reserve(node.children.size());
    for (const Member& child : node.children) members.Json::object_t::Container::emplace_back(child.key, nullptr);
  }
  auto value = json.begin();
  for (const Member& child : node.children)
    take(child.value, child.key_origin, join_pointer(pointer, child.key), *value++);
}

const Document::Place& Document::place(std::string_view pointer) const {
  std::string nearest(pointer);
  auto found = places_.find(nearest);
  for (; found == places_.end(); found = places_.find(nearest)) {
    const std::size_t slash = nearest.rfind('/');
    nearest.resize(slash == std::string::npos ? 0 : slash);
  }
  return found->second;
}

const Json* Document::value(std::string_view pointer) const {
  if (pointer.empty()) return root_.get();
  const auto found = places_.find(std::string(pointer));
  return found == places_.end() ? nullptr : found->second.json;
}

std::uint64_t Document::hash(const std::vector<std::string>& keys) const {
  auto hashed = Json::object();
  for (const auto& [key, value] : root().items())
    if (keys.empty() || std::ranges::find(keys, key) != keys.end())
      hashed.get_ref<Json::object_t&>().Json::object_t::Container::emplace_back(key, value);
  base::Fnv1a hash;
  hash.add(hashed.dump());
  return hash.value();
}

}  // namespace binnacle::internal::config

namespace binnacle {

Config Config::load(const std::filesystem::path& path, const LoadOptions& options) {
  Diagnostics diagnostics;
  Config config;
  config.document_ =
      std::make_shared<const internal::config::Document>(internal::config::Document::load(path, options, diagnostics));
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return config;
}

std::string Config::text() const { return document_->root().dump(); }
bool Config::contains(std::string_view pointer) const { return document_->value(pointer); }
Origin Config::origin(std::string_view pointer) const { return document_->origin(pointer); }
Origin Config::key_origin(std::string_view pointer) const { return document_->key_origin(pointer); }

}  // namespace binnacle
