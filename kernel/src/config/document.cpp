// SPDX-License-Identifier: Apache-2.0
// The config as one JSON document.
#include "config/document.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/hash.hpp"
#include "binnacle/config.hpp"
#include "binnacle/section.hpp"
#include "config/extends.hpp"
#include "config/node.hpp"
#include "config/pointer.hpp"
#include "config/settings.hpp"
#include "config/variables.hpp"

namespace binnacle::config {

namespace fs = std::filesystem;

namespace {

bool is_inside_one_of(const std::string& setting, const std::vector<std::string>& patches) {
  const std::string pointer = setting.substr(0, setting.find('='));
  return std::any_of(patches.begin(), patches.end(),
                     [&](const std::string& patch) { return pointer == patch || pointer.starts_with(patch + "/"); });
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

Document Document::load(const fs::path& path, const LoadOptions& options, Diagnostics& diagnostics) {
  return build(path, nullptr, options, diagnostics);
}

Document Document::parse(std::string_view text, const fs::path& file_name, const LoadOptions& options,
                         Diagnostics& diagnostics) {
  return build(file_name, &text, options, diagnostics);
}

Document Document::build(const fs::path& path, const std::string_view* text, const LoadOptions& options,
                         Diagnostics& diagnostics) {
  Extends extends(diagnostics);
  std::optional<Node> root = extends.resolve(path, text);
  Document document;
  if (!root) return document;
  std::vector<std::string> patches;
  for (const auto& section : options.sections)
    for (auto& place : section->patches()) patches.push_back(std::move(place));
  drop_nulls(*root, patches);
  const auto current_folder = std::make_shared<const fs::path>(fs::current_path());
  const auto set = [&](bool wants_inside_a_patch) {
    for (const std::string& setting : options.sets)
      if (is_inside_one_of(setting, options.patches) == wants_inside_a_patch)
        apply_setting(*root, setting, current_folder, diagnostics);
  };
  set(true);
  for (const std::string& pointer : options.patches) {
    apply_patch(*root, pointer, diagnostics);
    drop_nulls(*root, patches);
  }
  document.is_patched_ = !options.patches.empty();
  set(false);
  drop_nulls(*root, patches);  // once more, for what patches and --set brought
  fill_in_variables(*root, options.vars, current_folder, diagnostics);
  document.root_ = to_json(*root);
  document.record(*root, root->origin, "");
  return document;
}

void Document::record(const Node& node, const Origin& key, const std::string& pointer) {
  places_[pointer] = {node.origin, key, node.folder ? *node.folder : fs::path()};
  for (std::size_t i = 0; i < node.elements.size(); ++i)
    record(node.elements[i], node.elements[i].origin, join_pointer(pointer, i));
  for (const Member& member : node.members) record(member.value, member.key_origin, join_pointer(pointer, member.key));
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

std::string Document::resolve_path(std::string_view pointer) const {
  const Json* text = value(pointer);
  if (!text || !text->is_string()) throw std::invalid_argument("there is no text at '" + std::string(pointer) + "'");
  return (base_dir(pointer) / text->get<std::string>()).lexically_normal().string();
}

const Json* Document::value(std::string_view pointer) const {
  try {
    const Json::json_pointer where{std::string(pointer)};
    return root_.contains(where) ? &root_.at(where) : nullptr;
  } catch (const Json::exception&) {
    return nullptr;
  }
}

std::uint64_t Document::hash(const std::vector<std::string>& keys) const {
  auto hashed = Json::object();
  for (const auto& [key, value] : root_.items())
    if (keys.empty() || std::find(keys.begin(), keys.end(), key) != keys.end()) hashed[key] = value;
  base::Fnv1a hash;
  hash.add(hashed.dump());
  return hash.value();
}

}  // namespace binnacle::config

namespace binnacle {

Config Config::load(const std::filesystem::path& path, const LoadOptions& options) {
  Diagnostics diagnostics;
  Config config;
  config.document_ = std::make_shared<const config::Document>(config::Document::load(path, options, diagnostics));
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return config;
}

std::string Config::text() const { return document_->root().dump(); }
Origin Config::origin(std::string_view pointer) const { return document_->origin(pointer); }
Origin Config::key_origin(std::string_view pointer) const { return document_->key_origin(pointer); }

}  // namespace binnacle
