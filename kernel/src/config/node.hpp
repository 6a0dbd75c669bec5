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

struct Member;

struct Node {
  enum class Kind { null, boolean, number, string, array, object };

  Kind kind = Kind::null;
  nlohmann::ordered_json scalar;  ///< of the first four kinds
  std::vector<Node> elements;
  std::vector<Member> members;
  Origin origin;
  std::shared_ptr<const std::filesystem::path> folder;  ///< where a relative path in the value starts

  Member* find(std::string_view key);
  const Member* find(std::string_view key) const;
  std::vector<std::string> keys() const;
  void erase(std::string_view key);
};

struct Member {
  std::string key;
  Origin key_origin;
  Node value;
};

/// For messages: "an object", "a text", "null" …
const char* kind_name(Node::Kind kind);

Node scalar_node(nlohmann::ordered_json value, Origin origin, std::shared_ptr<const std::filesystem::path> folder);

/// RFC 7386, but a deleted member leaves a null behind, so that a patch may itself be made of patches. Keys
/// of the target keep their order, new ones follow.
void merge_patch(Node& target, Node patch);

/// Removes the members that are null, except those of objects of merge patches: `patches` are the JSON pointers at which
/// they stand, `*` for any key.
void drop_nulls(Node& root, const std::vector<std::string>& patches);

nlohmann::ordered_json to_json(const Node& node);

std::size_t node_count(const Node& node);

}  // namespace binnacle::config
