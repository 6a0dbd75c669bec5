// SPDX-License-Identifier: Apache-2.0
// A JSON value that knows where it stands.
#include "config/node.hpp"

#include <algorithm>
#include <utility>

#include "config/pointer.hpp"

namespace binnacle::config {

Member* Node::find(std::string_view key) {
  const auto found = std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.key == key; });
  return found == members.end() ? nullptr : &*found;
}

std::vector<std::string> Node::keys() const {
  std::vector<std::string> result;
  for (const Member& member : members) result.push_back(member.key);
  return result;
}

void Node::erase(std::string_view key) {
  std::erase_if(members, [&](const Member& m) { return m.key == key; });
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
  for (Member& member : patch.members) {
    Member* known = target.find(member.key);
    if (member.value.json.is_null() || (known && known->value.json.is_null())) {
      target.erase(member.key);
      known = nullptr;
    }
    if (known) {
      known->key_origin = std::move(member.key_origin);
      merge_patch(known->value, std::move(member.value));
    } else {
      target.members.push_back(std::move(member));
    }
  }
}

namespace {

using Tokens = std::vector<std::string>;

/// `patches`: those places of patches that lie at the node, which is `depth` tokens deep, or below it.
void drop_nulls_below(Node& node, const std::vector<Tokens>& patches, std::size_t depth) {
  std::erase_if(node.members, [](const Member& member) { return member.value.json.is_null(); });
  if (std::any_of(patches.begin(), patches.end(), [&](const Tokens& place) { return place.size() == depth; })) return;
  for (Member& member : node.members) {
    std::vector<Tokens> below;
    for (const Tokens& place : patches)
      if (place[depth] == member.key || place[depth] == "*") below.push_back(place);
    drop_nulls_below(member.value, below, depth + 1);
  }
  for (Node& element : node.elements) drop_nulls_below(element, {}, depth + 1);
}

}  // namespace

void drop_nulls(Node& root, const std::vector<std::string>& patches) {
  std::vector<Tokens> places;
  for (const std::string& pointer : patches)
    if (auto tokens = split_pointer(pointer); tokens && !tokens->empty()) places.push_back(std::move(*tokens));
  drop_nulls_below(root, places, 0);
}

Json to_json(const Node& node) {
  Json json = node.json;
  for (const Node& element : node.elements) json.push_back(to_json(element));
  for (const Member& member : node.members) json[member.key] = to_json(member.value);
  return json;
}

std::size_t node_count(const Node& node) {
  std::size_t count = 1;
  for (const Node& element : node.elements) count += node_count(element);
  for (const Member& member : node.members) count += node_count(member.value);
  return count;
}

}  // namespace binnacle::config
