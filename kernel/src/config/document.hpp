// SPDX-License-Identifier: Apache-2.0
// The config as one JSON document: extends merged, --set applied, variables filled in, every value's origin
// known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "binnacle/config.hpp"

namespace binnacle::config {

struct Node;

/// Order of work: comments away, `extends` (RFC 7386, the innermost base first), patches, `--set`, variables. A member
/// that is null deletes what it meets and is then gone itself; only objects of merge
/// patches, where a section of LoadOptions has them, keep theirs. Whatever is wrong goes to the diagnostics; the document then holds as much as could be read.
class Document {
 public:
  /// `text` stands for what is in the file, if it is given.
  static Document load(const std::filesystem::path& path, const LoadOptions& options, Diagnostics& diagnostics,
                       std::optional<std::string_view> text = std::nullopt);

  /// Always an object; without `extends`.
  const nlohmann::ordered_json& root() const { return root_; }

  /// The value at the pointer; null where there is none, or the text is no pointer.
  const nlohmann::ordered_json* value(std::string_view pointer) const;

  /// Where the value stands, or that of its nearest ancestor if there is none.
  Origin origin(std::string_view pointer) const { return place(pointer).value; }
  /// Where its key stands; elements of arrays, which have none, give the value's place.
  Origin key_origin(std::string_view pointer) const { return place(pointer).key; }
  /// Folder from which a relative path starts: that of the file which named the value; for a string which
  /// begins with a variable, of the file which gave the variable; the current one for what came from the
  /// command line. Absolute.
  std::filesystem::path base_dir(std::string_view pointer) const { return place(pointer).folder; }

  /// Whether some of its own patches were merged over it.
  bool is_patched() const { return is_patched_; }

  /// FNV-1a of the compact dump of what stands under these keys of root(), or of all of it.
  std::uint64_t hash(const std::vector<std::string>& keys = {}) const;

 private:
  struct Place {
    Origin value;
    Origin key;
    std::filesystem::path folder;
  };
  const Place& place(std::string_view pointer) const;
  /// Notes the places of a value and of all in it; the value itself.
  nlohmann::ordered_json take(const Node& node, const Origin& key, const std::string& pointer);

  nlohmann::ordered_json root_ = nlohmann::ordered_json::object();
  std::unordered_map<std::string, Place> places_{{std::string(), Place{}}};
  bool is_patched_ = false;
};

}  // namespace binnacle::config
