// SPDX-License-Identifier: Apache-2.0
// Config: a config as resolved, before anything is composed of it. For whoever reads sections of their own from it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/diagnostic.hpp"

namespace binnacle {

namespace internal::config {
class Document;
struct JsonOf;
}  // namespace internal::config
class Composition;
class Section;        // binnacle/section.hpp
struct LinkedPlugin;  // binnacle/catalog.hpp

/// What the command line, or the program, adds to a config.
struct LoadOptions {
  std::map<std::string, std::string> vars;  ///< --var name=value; replaces what the config's "vars" says
  std::vector<std::string> sets;            ///< --set PTR=V, in order
  /// JSON pointers to objects of the config, each merged over the whole of it (RFC 7386) before `sets`.
  std::vector<std::string> patches = {};
  /// Readers of the sections that are not the kernel's. With none, sections that the kernel does not know are left alone,
  /// unless one looks like a misspelt key of the kernel's; with some, a key that is nobody's is an error.
  std::vector<std::shared_ptr<const Section>> sections = {};
  std::vector<std::shared_ptr<const LinkedPlugin>> linked_plugins = {};
  /// Searched for plugins after those of BINNACLE_PLUGIN_PATH, in place of what lies beside the program; one may be missing.
  std::vector<std::filesystem::path> plugin_folders = {};
  /// The config itself, where its file is not to be read: messages name the file, and relative paths start at its folder.
  std::optional<std::string> text = {};
};

/// A resolved config, with the place of every value in its files; copies share one document.
class Config {
 public:
  /// extends merged, patches, --set and variables applied; nothing else is checked. Throws ConfigError.
  static Config load(const std::filesystem::path& path, const LoadOptions& options = {});

  /// JSON text.
  std::string text() const;
  /// Whether there is a value at this JSON pointer.
  bool contains(std::string_view pointer) const;
  /// Where the value stands, or that of its nearest ancestor if there is none.
  Origin origin(std::string_view pointer) const;
  /// Where its key stands.
  Origin key_origin(std::string_view pointer) const;

 private:
  friend class Composition;

  std::shared_ptr<const internal::config::Document> document_;
};

/// pointer + "/" + token, its `~` and `/` escaped.
std::string join_pointer(std::string_view pointer, std::string_view token);
std::string join_pointer(std::string_view pointer, std::size_t index);

}  // namespace binnacle
