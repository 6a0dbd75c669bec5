// SPDX-License-Identifier: Apache-2.0
// Config: a config as resolved, before anything is composed of it. For whoever reads sections of their own from it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/diagnostic.hpp"

namespace binnacle {

namespace internal::config {
class Document;
struct JsonOf;
}  // namespace internal::config
class Section;

/// What the command line adds to a config.
struct LoadOptions {
  std::map<std::string, std::string> vars;  ///< --var name=value; replaces what the config's "vars" says
  std::vector<std::string> sets;            ///< --set PTR=V, in order
  /// JSON pointers to objects of the config, each merged over the whole of it (RFC 7386) before `sets`.
  std::vector<std::string> patches = {};
  /// Readers of the sections that are not the kernel's. With none, sections that the kernel does not know are left alone,
  /// unless one looks like a misspelt key of the kernel's; with some, a key that is nobody's is an error.
  std::vector<std::shared_ptr<const Section>> sections = {};
};

class Config {
 public:
  /// extends merged, patches, --set and variables applied; nothing else is checked. Throws ConfigError.
  static Config load(const std::filesystem::path& path, const LoadOptions& options = {});

  /// JSON text.
  std::string text() const;
  /// Where the value stands, or that of its nearest ancestor if there is none.
  Origin origin(std::string_view pointer) const;
  /// Where its key stands.
  Origin key_origin(std::string_view pointer) const;

 private:
  std::shared_ptr<const internal::config::Document> document_;
};

/// pointer + "/" + token, its `~` and `/` escaped.
std::string join_pointer(std::string_view pointer, std::string_view token);
std::string join_pointer(std::string_view pointer, std::size_t index);

}  // namespace binnacle
