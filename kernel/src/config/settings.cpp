// SPDX-License-Identifier: Apache-2.0
// `--set /pointer=value`, applied to a resolved config.
#include "config/settings.hpp"

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "config/json_reader.hpp"
#include "config/pointer.hpp"

namespace binnacle::config {

namespace {

const Origin command_line{"--set", 0, 0};

using base::in_quotes;

class Setter {
 public:
  Setter(std::string pointer, Diagnostics& diagnostics) : pointer_(std::move(pointer)), diagnostics_(diagnostics) {}

  void report(const std::string& message) const { diagnostics_.error("B029", command_line, pointer_, message); }

  void assign(Node& root, const std::vector<std::string>& tokens, Node value) const {
    const bool erase = value.json.is_null();
    Node* parent = nullptr;
    Node* node = &root;
    std::string at;
    for (const std::string& token : tokens) {
      parent = node;
      node = parent->json.is_object() ? object_child(*parent, at, token, !erase)
             : parent->json.is_array()
                 ? array_child(*parent, at, token, !erase)
                 : nothing(in_quotes(at) + " is " + kind_name(*parent) + ", not an object or list");
      if (!node) return;
      at = join_pointer(at, token);
    }
    if (erase && parent->json.is_object()) return parent->erase(tokens.back());
    if (erase) return void(parent->elements.erase(parent->elements.begin() + (node - parent->elements.data())));
    if (Member* member = parent->find(tokens.back())) member->key_origin = command_line;
    *node = std::move(value);
  }

 private:
  Node* nothing(const std::string& message) const {
    report(message);
    return nullptr;
  }

  Node* object_child(Node& parent, const std::string& at, const std::string& token, bool make) const {
    if (Member* member = parent.find(token)) return &member->value;
    if (make) {
      parent.members.push_back({token, command_line, {Json::object(), command_line, parent.folder}});
      return &parent.members.back().value;
    }
    const std::string meant = closest(token, parent.keys());
    return nothing("there is nothing to delete" +
                   (meant.empty() ? "" : "; did you mean " + in_quotes(join_pointer(at, meant)) + "?"));
  }

  Node* array_child(Node& parent, const std::string& at, const std::string& token, bool make) const {
    if (token == "-" && make) return &parent.elements.emplace_back(Node{Json::object()});
    if (const auto index = index_in(parent.elements.size(), token)) return &parent.elements[*index];
    return nothing(in_quotes(at) + " is a list of " + std::to_string(parent.elements.size()) + "; " + in_quotes(token) +
                   " is none of its indices (which count from 0" + (make ? "; '-' appends)" : ")"));
  }

  std::string pointer_;
  Diagnostics& diagnostics_;
};

}  // namespace

void apply_setting(Node& root, const std::string& setting, const Folder& current_folder, Diagnostics& diagnostics) {
  const std::size_t equals = setting.find('=');
  const std::string pointer = setting.substr(0, equals);
  const Setter setter(pointer.starts_with('/') ? pointer : "", diagnostics);
  if (!is_utf8(setting)) return setter.report("--set is not UTF-8");
  if (equals == std::string::npos) return setter.report(in_quotes(setting) + " does not read /pointer=value");
  if (!pointer.starts_with('/')) {
    return setter.report(in_quotes(pointer) + " is no JSON pointer; did you mean " + in_quotes("/" + pointer) + "?");
  }
  const auto tokens = split_pointer(pointer);
  if (!tokens) return setter.report("a '~' in a JSON pointer is written '~0', a '/' inside a key '~1'");
  if (tokens->back() == "extends") return setter.report("extends cannot be set; it is resolved before --set");
  const std::string text = setting.substr(equals + 1);
  std::optional<Node> value = read_json_value(text, "--set", current_folder);
  const bool looks_like_json = text.starts_with('{') || text.starts_with('[') || text.starts_with('"');
  if (!value && looks_like_json) return setter.report(in_quotes(text) + " begins like JSON but is not");
  if (!value) value = Node{text, command_line, current_folder};
  setter.assign(root, *tokens, *std::move(value));
}

}  // namespace binnacle::config
