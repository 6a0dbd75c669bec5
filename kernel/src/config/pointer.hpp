// SPDX-License-Identifier: Apache-2.0
// JSON pointers (RFC 6901) as text.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/config.hpp"

namespace binnacle::config {

/// `~` becomes ~0 and `/` becomes ~1.
std::string escape_token(std::string_view token);

/// The unescaped tokens; nothing if the text is no pointer. "" has none.
std::optional<std::vector<std::string>> split_pointer(std::string_view pointer);

/// "/a/b" of "/a/b/c"; "" stays "".
std::string parent_pointer(std::string_view pointer);

}  // namespace binnacle::config
