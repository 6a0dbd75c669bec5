// SPDX-License-Identifier: Apache-2.0
// A JSON value that knows where it stands: what configs are read into, merged in and printed from.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"

namespace binnacle::internal::config {

using Json = nlohmann::ordered_json;
using Folder = std::shared_ptr<const std::filesystem::path>;
using Tokens = std::vector<std::string>;

struct Member;

// ---- what a config may take, whoever wrote it

constexpr std::size_t most_bytes = 16 * 1024 * 1024;     ///< of a file, and of texts made of variables
constexpr std::size_t most_values = 500'000;             ///< of a file, and of all that is copied by `extends`
constexpr std::size_t most_pointers = 64 * 1024 * 1024;  ///< bytes of the pointers to all values: keys that are long
constexpr std::size_t most_extends = 10'000;             ///< that are followed
constexpr std::size_t deepest_chain = 100;               ///< of `extends`, and of variables made of others
constexpr const char* too_large = "B033";                ///< the code of an error about one of these
constexpr const char* pointers_too_long =
    "its keys are too long: the JSON pointers to its values have more than 64 MiB";

/// Where the members of a node are, by key: made when there are many and one is looked for. A copy begins anew.
class KeyIndex {
 public:
  KeyIndex() = default;
  KeyIndex(const KeyIndex&) {}
  KeyIndex(KeyIndex&&) noexcept = default;
  KeyIndex& operator=(const KeyIndex&) {
    forget();
    return *this;
  }
  KeyIndex& operator=(KeyIndex&&) noexcept = default;
  ~KeyIndex() = default;

  /// The place among the children, or their number: there is none. Of equal keys the first.
  std::size_t find(const std::vector<Member>& children, std::string_view key);
  /// After any change but new children at the end.
  void forget() { places_.reset(); }

 private:
  struct Places {
    std::unordered_map<std::string, std::size_t> by_key;
    std::size_t known = 0;  // so many of the children are in it, the first ones
  };
  std::unique_ptr<Places> places_;
};

struct Node {
  Json json;  ///< the value; an empty list or object where children follow
  Origin origin;
  Folder folder;  ///< where a relative path in the value starts
  std::vector<Member> children;
  KeyIndex index;

  Node(Json value = nullptr, Origin place = {}, Folder start = {});  // NOLINT(google-explicit-constructor): as a struct
  Member* find(std::string_view key);
  const Member* find(std::string_view key) const { return const_cast<Node*>(this)->find(key); }
  /// The names that an object's members have.
  std::vector<std::string> keys() const;
  void erase(std::string_view key);
  /// Removes the children for which it is true, and numbers those of a list anew.
  template <class IsUnwanted>
  void erase_if(const IsUnwanted& is_unwanted);
};

/// A member of an object, or an element of a list: its key is its index, and stands where the value does.
struct Member {
  std::string key;
  Origin key_origin;
  Node value;
};

// Defined where Member is complete: clang 14 with libstdc++ asks for that.
inline Node::Node(Json value, Origin place, Folder start)
    : json(std::move(value)), origin(std::move(place)), folder(std::move(start)) {}

template <class IsUnwanted>
void Node::erase_if(const IsUnwanted& is_unwanted) {
  if (std::erase_if(children, is_unwanted) == 0) return;
  index.forget();
  if (json.is_array())
    for (std::size_t i = 0; i < children.size(); ++i) children[i].key = std::to_string(i);
}

/// For messages: "an object", "a text", "null" …
std::string kind_name(const Node& node);

/// RFC 7386, but a deleted member leaves a null behind, so that a patch may itself be made of patches. Keys
/// of the target keep their order, new ones follow.
void merge_patch(Node& target, Node patch);

/// Removes the members that are null, except those of objects of merge patches: `patches` are the places at which they
/// stand, `*` for any key. The node is `depth` tokens deep, and no place is above it.
void drop_nulls(Node& node, const std::vector<Tokens>& patches, std::size_t depth = 0);

/// Bytes of the pointers to all values below, where the node's own has `own`.
std::size_t pointer_bytes(const Node& node, std::size_t own = 0);

/// The unescaped tokens of a JSON pointer (RFC 6901); nothing if the text is none. "" has none.
std::optional<Tokens> split_pointer(std::string_view pointer);

// ---- reading, in json_reader.cpp

/// Lines and columns count from 1, columns in characters (code points). Goes on after a duplicate key and
/// after a comma too many or too few; nothing if the rest cannot be read.
std::optional<Node> read_json(std::string_view text, const std::string& file_name, const Folder& folder,
                              Diagnostics& diagnostics);

/// A single value without comments, as given to --set; nothing if the text is not JSON. Its places have no line.
std::optional<Node> read_json_value(std::string_view text, const std::string& origin_name, const Folder& folder);

bool is_utf8(std::string_view text);

// ---- the steps from a file to a document that are more than a few lines, each in a file of its name

/// The file, or the text in its place, with everything that it extends; deleted members are still there as null.
///
/// An object that extends "other.json#/a/b" is what resolving other.json gives at /a/b, merged over by the object. Only
/// what is asked for is resolved, so one part of a file may extend another part of the same file.
std::optional<Node> resolve_extends(const std::filesystem::path& path, std::optional<std::string_view> text,
                                    Diagnostics& diagnostics);

/// Fills "${name}" from the config's "vars" and from --var into every text below root, "vars" itself included. A text
/// that is one "${name}" and nothing else takes the variable's value with its type. A text that begins with a variable
/// takes that variable's folder.
void fill_in_variables(Node& root, const std::map<std::string, std::string>& given, const Folder& current_folder,
                       Diagnostics& diagnostics);

}  // namespace binnacle::internal::config
