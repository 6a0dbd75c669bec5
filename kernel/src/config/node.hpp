// SPDX-License-Identifier: Apache-2.0
// A JSON value that knows where it stands: what configs are read into, merged in and printed from.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/diagnostic.hpp"

namespace binnacle::config {

using Json = nlohmann::ordered_json;
using Folder = std::shared_ptr<const std::filesystem::path>;

struct Member;

struct Node {
  Json json;  ///< the value; an empty list or object where elements or members follow
  Origin origin = {};
  Folder folder = {};  ///< where a relative path in the value starts
  std::vector<Node> elements = {};
  std::vector<Member> members = {};

  Member* find(std::string_view key);
  const Member* find(std::string_view key) const { return const_cast<Node*>(this)->find(key); }
  std::vector<std::string> keys() const;
  void erase(std::string_view key);
};

struct Member {
  std::string key;
  Origin key_origin;
  Node value;
};

/// For messages: "an object", "a text", "null" …
std::string kind_name(const Node& node);

/// RFC 7386, but a deleted member leaves a null behind, so that a patch may itself be made of patches. Keys
/// of the target keep their order, new ones follow.
void merge_patch(Node& target, Node patch);

/// Removes the members that are null, except those of objects of merge patches: `patches` are the JSON pointers at which
/// they stand, `*` for any key.
void drop_nulls(Node& root, const std::vector<std::string>& patches);

Json to_json(const Node& node);

std::size_t node_count(const Node& node);

}  // namespace binnacle::config
