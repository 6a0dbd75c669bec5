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

const Member* Node::find(std::string_view key) const { return const_cast<Node*>(this)->find(key); }

std::vector<std::string> Node::keys() const {
  std::vector<std::string> result;
  for (const Member& member : members) result.push_back(member.key);
  return result;
}

void Node::erase(std::string_view key) {
  std::erase_if(members, [&](const Member& m) { return m.key == key; });
}

const char* kind_name(Node::Kind kind) {
  switch (kind) {
    case Node::Kind::null: return "null";
    case Node::Kind::boolean: return "true or false";
    case Node::Kind::number: return "a number";
    case Node::Kind::string: return "a text";
    case Node::Kind::array: return "a list";
    default: return "an object";
  }
}

Node scalar_node(nlohmann::ordered_json value, Origin origin, std::shared_ptr<const std::filesystem::path> folder) {
  Node node;
  node.kind = value.is_string()    ? Node::Kind::string
              : value.is_number()  ? Node::Kind::number
              : value.is_boolean() ? Node::Kind::boolean
                                   : Node::Kind::null;
  node.scalar = std::move(value);
  node.origin = std::move(origin);
  node.folder = std::move(folder);
  return node;
}

void merge_patch(Node& target, Node patch) {
  if (patch.kind != Node::Kind::object || target.kind != Node::Kind::object) {
    target = std::move(patch);
    return;
  }
  target.origin = std::move(patch.origin);
  target.folder = std::move(patch.folder);
  for (Member& member : patch.members) {
    Member* known = target.find(member.key);
    const bool was_deleted = known && known->value.kind == Node::Kind::null;
    if (member.value.kind == Node::Kind::null || was_deleted) {
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

bool is_null(const Member& member) { return member.value.kind == Node::Kind::null; }

/// `patches`: those places of patches that lie below the node, which is `depth` tokens deep.
void drop_nulls_below(Node& node, const std::vector<Tokens>& patches, std::size_t depth) {
  std::erase_if(node.members, is_null);
  for (Member& member : node.members) {
    std::vector<Tokens> below;
    bool holds_patches = false;
    for (const Tokens& place : patches) {
      if (place[depth] != member.key && place[depth] != "*") continue;
      if (place.size() == depth + 1)
        holds_patches = true;
      else
        below.push_back(place);
    }
    if (holds_patches)
      std::erase_if(member.value.members, is_null);
    else
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

nlohmann::ordered_json to_json(const Node& node) {
  if (node.kind == Node::Kind::array) {
    auto array = nlohmann::ordered_json::array();
    for (const Node& element : node.elements) array.push_back(to_json(element));
    return array;
  }
  if (node.kind == Node::Kind::object) {
    auto object = nlohmann::ordered_json::object();
    for (const Member& member : node.members) object.push_back({member.key, to_json(member.value)});
    return object;
  }
  return node.scalar;
}

std::size_t node_count(const Node& node) {
  std::size_t count = 1;
  for (const Node& element : node.elements) count += node_count(element);
  for (const Member& member : node.members) count += node_count(member.value);
  return count;
}

}  // namespace binnacle::config
