// SPDX-License-Identifier: Apache-2.0
// A JSON value that knows where it stands, and the pointers to its parts.
#include "config/node.hpp"

#include <algorithm>

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

std::size_t KeyIndex::find(const std::vector<Member>& children, std::string_view key) {
  constexpr std::size_t many = 32;
  if (children.size() < many)
    return static_cast<std::size_t>(std::ranges::find(children, key, &Member::key) - children.begin());
  if (!places_) places_ = std::make_unique<Places>();
  for (std::size_t& known = places_->known; known < children.size(); ++known)
    places_->by_key.try_emplace(children[known].key, known);
  const auto found = places_->by_key.find(std::string(key));
  return found == places_->by_key.end() ? children.size() : found->second;
}

Member* Node::find(std::string_view key) {
  const std::size_t found = index.find(children, key);
  return found == children.size() ? nullptr : &children[found];
}

std::vector<std::string> Node::keys() const {
  std::vector<std::string> result;
  if (json.is_object())
    for (const Member& member : children) result.push_back(member.key);
  return result;
}

void Node::erase(std::string_view key) {
  erase_if([&](const Member& child) { return child.key == key; });
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
  std::vector<std::size_t> replaced;  // each key is there once
  for (Member& member : patch.children) {
    Member* const known = target.find(member.key);
    if (known && !member.value.json.is_null() && !known->value.json.is_null()) {
      known->key_origin = std::move(member.key_origin);
      merge_patch(known->value, std::move(member.value));
      continue;
    }
    if (known) replaced.push_back(static_cast<std::size_t>(known - target.children.data()));
    target.children.push_back(std::move(member));
  }
  if (replaced.empty()) return;
  std::vector<bool> is_replaced(target.children.size());
  for (const std::size_t place : replaced) is_replaced[place] = true;
  target.erase_if(
      [&](const Member& child) { return is_replaced[static_cast<std::size_t>(&child - target.children.data())]; });
}

std::size_t pointer_bytes(const Node& node, std::size_t own) {
  std::size_t bytes = own;
  for (const Member& child : node.children) bytes += pointer_bytes(child.value, own + 1 + child.key.size());
  return bytes;
}

void drop_nulls(Node& node, const std::vector<Tokens>& patches, std::size_t depth) {
  const bool is_object = node.json.is_object();
  if (is_object) node.erase_if([](const Member& member) { return member.value.json.is_null(); });
  if (std::ranges::any_of(patches, [&](const Tokens& place) { return place.size() == depth; })) return;
  for (Member& child : node.children) {
    std::vector<Tokens> below;
    for (const Tokens& place : patches)
      if (is_object && (place[depth] == child.key || place[depth] == "*")) below.push_back(place);
    drop_nulls(child.value, below, depth + 1);
  }
}

}  // namespace binnacle::internal::config
