// SPDX-License-Identifier: Apache-2.0
// The config as one JSON document.
#include "config/document.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/hash.hpp"
#include "binnacle/section.hpp"
#include "config/extends.hpp"
#include "config/node.hpp"
#include "config/pointer.hpp"
#include "config/settings.hpp"
#include "config/variables.hpp"

namespace binnacle::config {

namespace fs = std::filesystem;

class DocumentBuilder {
 public:
  static Document build(const fs::path& path, const std::string_view* text, const LoadOptions& options,
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
    for (const std::string& pointer : options.patches) apply_patch(*root, pointer, patches, diagnostics);
    document.is_patched_ = !options.patches.empty();
    set(false);
    drop_nulls(*root, patches);  // once more, for what patches and --set brought
    fill_in_variables(*root, options.vars, current_folder, diagnostics);
    document.root_ = to_json(*root);
    record(document, *root, root->origin, "");
    return document;
  }

 private:
  static bool is_inside_one_of(const std::string& setting, const std::vector<std::string>& patches) {
    const std::string pointer = setting.substr(0, setting.find('='));
    return std::any_of(patches.begin(), patches.end(),
                       [&](const std::string& patch) { return pointer == patch || pointer.starts_with(patch + "/"); });
  }

  static void apply_patch(Node& root, const std::string& pointer, const std::vector<std::string>& patches,
                          Diagnostics& diagnostics) {
    const Node* patch = &root;
    const auto tokens = split_pointer(pointer);
    for (std::size_t i = 0; patch && tokens && i < tokens->size(); ++i) {
      const Member* member = patch->find((*tokens)[i]);
      patch = member ? &member->value : nullptr;
    }
    if (!tokens || !patch || patch->kind != Node::Kind::object) {
      diagnostics.error("B029", root.origin, pointer, "there is no object here to be merged over the config");
      return;
    }
    const Origin origin = root.origin;
    const auto folder = root.folder;
    merge_patch(root, Node(*patch));
    root.origin = origin;
    root.folder = folder;
    drop_nulls(root, patches);
  }

  static void record(Document& document, const Node& node, const Origin& key, const std::string& pointer) {
    document.places_[pointer] = {node.origin, key, node.folder ? *node.folder : fs::path()};
    for (std::size_t i = 0; i < node.elements.size(); ++i) {
      record(document, node.elements[i], node.elements[i].origin, join_pointer(pointer, i));
    }
    for (const Member& member : node.members) {
      record(document, member.value, member.key_origin, join_pointer(pointer, member.key));
    }
  }
};

Document Document::load(const fs::path& path, const LoadOptions& options, Diagnostics& diagnostics) {
  return DocumentBuilder::build(path, nullptr, options, diagnostics);
}

Document Document::parse(std::string_view text, const fs::path& file_name, const LoadOptions& options,
                         Diagnostics& diagnostics) {
  return DocumentBuilder::build(file_name, &text, options, diagnostics);
}

const Document::Place& Document::place(std::string_view pointer) const {
  std::string nearest(pointer);
  while (true) {
    const auto found = places_.find(nearest);
    if (found != places_.end()) return found->second;
    nearest = parent_pointer(nearest);
  }
}

Origin Document::origin(std::string_view pointer) const { return place(pointer).value; }

Origin Document::key_origin(std::string_view pointer) const { return place(pointer).key; }

fs::path Document::base_dir(std::string_view pointer) const { return place(pointer).folder; }

std::string Document::resolve_path(std::string_view pointer) const {
  const nlohmann::ordered_json::json_pointer where{std::string(pointer)};
  if (!root_.contains(where) || !root_.at(where).is_string()) {
    throw std::invalid_argument("there is no text at '" + std::string(pointer) + "'");
  }
  return (base_dir(pointer) / root_.at(where).get<std::string>()).lexically_normal().string();
}

std::uint64_t Document::hash(const std::vector<std::string>& keys) const {
  auto hashed = nlohmann::ordered_json::object();
  for (const auto& [key, value] : root_.items())
    if (keys.empty() || std::find(keys.begin(), keys.end(), key) != keys.end()) hashed[key] = value;
  base::Fnv1a hash;
  hash.add(hashed.dump());
  return hash.value();
}

}  // namespace binnacle::config
