// SPDX-License-Identifier: Apache-2.0
// Config: a config as resolved, before anything is composed of it. For whoever reads sections of their own from it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "binnacle/diagnostic.hpp"
#include "binnacle/load_options.hpp"

namespace binnacle {

namespace config {
class Document;
}

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
  std::shared_ptr<const config::Document> document_;
};

/// pointer + "/" + token, its `~` and `/` escaped.
std::string join_pointer(std::string_view pointer, std::string_view token);
std::string join_pointer(std::string_view pointer, std::size_t index);

}  // namespace binnacle
