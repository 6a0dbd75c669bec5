// SPDX-License-Identifier: Apache-2.0
// `--set /pointer=value`, applied to a resolved config.
#pragma once

#include <string>

#include "binnacle/diagnostic.hpp"
#include "config/node.hpp"

namespace binnacle::config {

/// The value is read as JSON, else it is a text; null deletes; a last token `-` appends to a list. Objects on
/// the way are made where they are missing.
void apply_setting(Node& root, const std::string& setting, const Folder& current_folder, Diagnostics& diagnostics);

}  // namespace binnacle::config
