// SPDX-License-Identifier: Apache-2.0
#include "binnacle/config.hpp"

#include "config/document.hpp"

namespace binnacle {

Config Config::load(const std::filesystem::path& path, const LoadOptions& options) {
  Diagnostics diagnostics;
  Config config;
  config.document_ = std::make_shared<const config::Document>(config::Document::load(path, options, diagnostics));
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return config;
}

std::string Config::text() const { return document_->root().dump(); }
Origin Config::origin(std::string_view pointer) const { return document_->origin(pointer); }
Origin Config::key_origin(std::string_view pointer) const { return document_->key_origin(pointer); }

}  // namespace binnacle
