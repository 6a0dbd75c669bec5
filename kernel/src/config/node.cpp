// SPDX-License-Identifier: Apache-2.0
// A JSON value that knows where it stands, and the pointers to its parts.
#include "config/node.hpp"

#include <algorithm>
#include <utility>

namespace binnacle {

std::string join_pointer(std::string_view pointer, std::string_view token) {
  std::string joined;
  joined.reserve(pointer.size() + 1 + token.size());
  joined.append(pointer).push_back('/');
  for (const char c : token)
    if (c == '~' || c == '/')
      joined.append(c == '~' ? "~0" : "~1");  // RFC 6901
    else
      joined.push_back(c);
  return joined;
}

std::string join_pointer(std::string_view pointer, std::size_t index) {
  return std::string(pointer) + "/" + std::to_string(index);
}

}  // namespace binnacle

namespace binnacle::internal::config {

std::optional<Tokens> split_pointer(std::string_view pointer) {
  try {
    Tokens tokens;
    for (Json::json_pointer rest{std::string(pointer)}; !rest.empty(); rest.pop_back()) tokens.push_back(rest.back());
    std::reverse(tokens.begin(), tokens.end());
    return tokens;
  } catch (const Json::parse_error&) {
    return std::nullopt;
  }
}

Member* Node::find(std::string_view key) {
  const auto found = std::ranges::find(children, key, &Member::key);
  return found == children.end() ? nullptr : &*found;
}

std::vector<std::string> Node::keys() const {
  std::vector<std::string> result;
  if (json.is_object())
    for (const Member& member : children) result.push_back(member.key);
  return result;
}

void Node::erase(std::string_view key) {
  std::erase_if(children, [&](const Member& child) { return child.key == key; });
  if (json.is_array())
    for (std::size_t i = 0; i < children.size(); ++i) children[i].key = std::to_string(i);
}

std::string kind_name(const Node& node) {
  if (node.json.is_null()) return "null";
  if (node.json.is_boolean()) return "true or false";
  if (node.json.is_string()) return "a text";
  return node.json.is_number() ? "a number" : node.json.is_array() ? "a list" : "an object";
}

void merge_patch(Node& target, Node patch) {
  if (!patch.json.is_object() || !target.json.is_object()) {
    target = std::move(patch);
    return;
  }
  target.origin = std::move(patch.origin);
  target.folder = std::move(patch.folder);
  for (Member& member : patch.children) {
    Member* known = target.find(member.key);
    if (member.value.json.is_null() || (known && known->value.json.is_null())) {
      target.erase(member.key);
      known = nullptr;
    }
    if (known) {
      known->key_origin = std::move(member.key_origin);
      merge_patch(known->value, std::move(member.value));
    } else {
      target.children.push_back(std::move(member));
    }
  }
}

void drop_nulls(Node& node, const std::vector<Tokens>& patches, std::size_t depth) {
  const bool is_object = node.json.is_object();
  if (is_object) std::erase_if(node.children, [](const Member& member) { return member.value.json.is_null(); });
  if (std::ranges::any_of(patches, [&](const Tokens& place) { return place.size() == depth; })) return;
  for (Member& child : node.children) {
    std::vector<Tokens> below;
    for (const Tokens& place : patches)
      if (is_object && (place[depth] == child.key || place[depth] == "*")) below.push_back(place);
    drop_nulls(child.value, below, depth + 1);
  }
}

}  // namespace binnacle::internal::config
