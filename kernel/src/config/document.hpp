// SPDX-License-Identifier: Apache-2.0
// The config as one JSON document: extends merged, --set applied, variables filled in, every value's origin
// known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "binnacle/section.hpp"

namespace binnacle::internal::config {

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
  const nlohmann::ordered_json& root() const { return *root_; }

  /// The value at the pointer; null where there is none, or the text is no pointer.
  const nlohmann::ordered_json* value(std::string_view pointer) const;

  /// Where the value stands, or that of its nearest ancestor if there is none.
  Origin origin(std::string_view pointer) const { return place(pointer).value; }
  /// Where its key stands; elements of arrays, which have none, give the value's place.
  Origin key_origin(std::string_view pointer) const { return place(pointer).key; }
  /// Folder from which a relative path starts: that of the file which named the value; for a string which begins with a
  /// variable, of the file which gave the variable; the current one for what came from the command line. Absolute.
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
    const nlohmann::ordered_json* json = nullptr;  // in *root_
  };
  const Place& place(std::string_view pointer) const;
  /// Notes the places of a value, which goes to `json`, and of all in it.
  void take(const Node& node, const Origin& key, const std::string& pointer, nlohmann::ordered_json& json);

  std::shared_ptr<const nlohmann::ordered_json> root_ =  // of all copies
      std::make_shared<nlohmann::ordered_json>(nlohmann::ordered_json::object());
  std::unordered_map<std::string, Place> places_{{std::string(), Place{}}};
  bool is_patched_ = false;
};

/// The JSON behind a Reader, which public headers do not name: something stands there.
struct JsonOf {
  static const nlohmann::ordered_json& at(const Reader& place) {
    return *static_cast<const nlohmann::ordered_json*>(place.json_);
  }
  /// A default of the component that stands there: it has no place of its own, nor has what is in it.
  static Reader as_default(Reader place, const nlohmann::ordered_json& json) {
    place.json_ = &json;
    place.is_default_ = true;
    return place;
  }
};

}  // namespace binnacle::internal::config
