// SPDX-License-Identifier: Apache-2.0
// `--set /pointer=value`, applied to a resolved config.
#include "config/settings.hpp"

#include <charconv>
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

std::optional<std::size_t> index_of(const std::string& token) {
  std::size_t index = 0;
  const auto [last, status] = std::from_chars(token.data(), token.data() + token.size(), index);
  if (status != std::errc() || last != token.data() + token.size()) return std::nullopt;
  return index;
}

class Setter {
 public:
  Setter(std::string pointer, Diagnostics& diagnostics) : pointer_(std::move(pointer)), diagnostics_(diagnostics) {}

  void tell(const std::string& message) const { diagnostics_.error("B029", command_line, pointer_, message); }

  /// The value that a token selects; nothing, and a message, where it cannot be.
  Node* child(Node& parent, const std::string& at, const std::string& token, bool make) const {
    if (parent.kind == Node::Kind::object) return object_child(parent, at, token, make);
    if (parent.kind == Node::Kind::array) return array_child(parent, at, token, make);
    tell(in_quotes(at) + " is " + kind_name(parent.kind) + ", not an object or list");
    return nullptr;
  }

 private:
  Node* object_child(Node& parent, const std::string& at, const std::string& token, bool make) const {
    if (Member* member = parent.find(token)) return &member->value;
    if (make) {
      Node empty;
      empty.kind = Node::Kind::object;
      empty.origin = command_line;
      empty.folder = parent.folder;
      parent.members.push_back({token, command_line, std::move(empty)});
      return &parent.members.back().value;
    }
    const std::string meant = closest(token, parent.keys());
    tell("there is nothing to delete" +
         (meant.empty() ? "" : "; did you mean " + in_quotes(join_pointer(at, meant)) + "?"));
    return nullptr;
  }

  Node* array_child(Node& parent, const std::string& at, const std::string& token, bool make) const {
    if (token == "-" && make) return &parent.elements.emplace_back();
    const std::optional<std::size_t> index = index_of(token);
    if (index && *index < parent.elements.size()) return &parent.elements[*index];
    tell(in_quotes(at) + " is a list of " + std::to_string(parent.elements.size()) + "; " + in_quotes(token) +
         " is none of its indices" + (make ? " (which count from 0; '-' appends)" : " (which count from 0)"));
    return nullptr;
  }

  std::string pointer_;
  Diagnostics& diagnostics_;
};

void erase_child(Node& parent, const std::string& token) {
  if (parent.kind == Node::Kind::object) {
    parent.erase(token);
  } else {
    parent.elements.erase(parent.elements.begin() + static_cast<std::ptrdiff_t>(index_of(token).value()));
  }
}

void assign(Node& root, const std::vector<std::string>& tokens, Node value, const Setter& setter) {
  const bool erase = value.kind == Node::Kind::null;
  Node* parent = nullptr;
  Node* node = &root;
  std::string at;
  for (const std::string& token : tokens) {
    parent = node;
    node = setter.child(*parent, at, token, !erase);
    if (!node) return;
    at = join_pointer(at, token);
    const bool appended = parent->kind == Node::Kind::array && token == "-";
    if (appended) node->kind = Node::Kind::object;
  }
  if (erase) return erase_child(*parent, tokens.back());
  if (Member* member = parent->kind == Node::Kind::object ? parent->find(tokens.back()) : nullptr) {
    member->key_origin = command_line;
  }
  *node = std::move(value);
}

}  // namespace

void apply_setting(Node& root, const std::string& setting,
                   const std::shared_ptr<const std::filesystem::path>& current_folder, Diagnostics& diagnostics) {
  const std::size_t equals = setting.find('=');
  const std::string pointer = setting.substr(0, equals);
  const Setter setter(pointer.starts_with('/') ? pointer : "", diagnostics);
  if (!is_utf8(setting)) return setter.tell("--set is not UTF-8");
  if (equals == std::string::npos) return setter.tell(in_quotes(setting) + " does not read /pointer=value");
  if (!pointer.starts_with('/')) {
    return setter.tell(in_quotes(pointer) + " is no JSON pointer; did you mean " + in_quotes("/" + pointer) + "?");
  }
  const auto tokens = split_pointer(pointer);
  if (!tokens) return setter.tell("a '~' in a JSON pointer is written '~0', a '/' inside a key '~1'");
  if (tokens->back() == "extends") return setter.tell("extends cannot be set; it is resolved before --set");
  const std::string text = setting.substr(equals + 1);
  std::optional<Node> value = read_json_value(text, "--set", current_folder);
  const bool looks_like_json = text.starts_with('{') || text.starts_with('[') || text.starts_with('"');
  if (!value && looks_like_json) return setter.tell(in_quotes(text) + " begins like JSON but is not");
  if (!value) value = scalar_node(text, command_line, current_folder);
  assign(root, *tokens, *std::move(value), setter);
}

}  // namespace binnacle::config
