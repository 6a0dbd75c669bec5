// SPDX-License-Identifier: Apache-2.0
// JSON pointers (RFC 6901) as text.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/config.hpp"

namespace binnacle::config {

/// The unescaped tokens; nothing if the text is no pointer. "" has none.
std::optional<std::vector<std::string>> split_pointer(std::string_view pointer);

/// The token as an index of a list of `size`; nothing if it is none of its indices.
std::optional<std::size_t> index_in(std::size_t size, std::string_view token);

}  // namespace binnacle::config
