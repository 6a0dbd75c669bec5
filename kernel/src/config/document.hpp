// SPDX-License-Identifier: Apache-2.0
// The config as one JSON document: extends merged, --set applied, variables filled in, every value's origin
// known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "binnacle/diagnostic.hpp"
#include "binnacle/load_options.hpp"

namespace binnacle::config {

struct Node;

/// Order of work: comments away, `extends` (RFC 7386, the innermost base first), patches, `--set`, variables. A member
/// that is null deletes what it meets and is then gone itself; only objects of merge
/// patches, where a section of LoadOptions has them, keep theirs. Whatever is wrong goes to the diagnostics; the document then holds as much as could be read.
class Document {
 public:
  static Document load(const std::filesystem::path& path, const LoadOptions& options, Diagnostics& diagnostics);
  /// The same for a text; relative paths in it start at the folder of file_name.
  static Document parse(std::string_view text, const std::filesystem::path& file_name, const LoadOptions& options,
                        Diagnostics& diagnostics);

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
  /// The string at the pointer as an absolute, normalised path. Throws std::invalid_argument if it is no
  /// string.
  std::string resolve_path(std::string_view pointer) const;

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
  static Document build(const std::filesystem::path& path, const std::string_view* text, const LoadOptions& options,
                        Diagnostics& diagnostics);
  void record(const Node& node, const Origin& key, const std::string& pointer);

  nlohmann::ordered_json root_ = nlohmann::ordered_json::object();
  std::unordered_map<std::string, Place> places_{{std::string(), Place{}}};
  bool is_patched_ = false;
};

}  // namespace binnacle::config
