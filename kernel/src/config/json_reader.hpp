// SPDX-License-Identifier: Apache-2.0
// Strict JSON with comments, read with the place of every key and value.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "binnacle/diagnostic.hpp"
#include "config/node.hpp"

namespace binnacle::config {

/// Lines and columns count from 1, columns in characters (code points). Goes on after a duplicate key and
/// after a comma too many or too few; nothing if the rest cannot be read.
std::optional<Node> read_json(std::string_view text, const std::string& file_name, const Folder& folder,
                              Diagnostics& diagnostics);

/// A single value without comments, as given to --set; nothing if the text is not JSON. Its places have no
/// line.
std::optional<Node> read_json_value(std::string_view text, const std::string& origin_name, const Folder& folder);

bool is_utf8(std::string_view text);

}  // namespace binnacle::config
