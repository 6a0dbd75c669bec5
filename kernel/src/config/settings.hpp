// SPDX-License-Identifier: Apache-2.0
// `--set /pointer=value`, applied to a resolved config.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "binnacle/diagnostic.hpp"
#include "config/node.hpp"

namespace binnacle::config {

/// The value is read as JSON, else it is a text; null deletes; a last token `-` appends to a list. Objects on
/// the way are made where they are missing.
void apply_setting(Node& root, const std::string& setting,
                   const std::shared_ptr<const std::filesystem::path>& current_folder, Diagnostics& diagnostics);

}  // namespace binnacle::config
