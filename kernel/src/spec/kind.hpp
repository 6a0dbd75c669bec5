// SPDX-License-Identifier: Apache-2.0
// Block kinds: "velocity.ned", "vector:3:rad/s", and the patterns that ports match them with.
#pragma once

#include <string>
#include <string_view>

#include "binnacle/unit.hpp"

namespace binnacle::spec {

/// Part by part between colons, `*` for any, a lone `*` for every kind; units by dimension: "vector:*:deg" matches
/// "vector:3:rad".
bool kind_matches(std::string_view pattern, std::string_view kind);

/// The kind with its units in canonical SI text ("vector:3:1/s*rad" is "vector:3:rad/s"), or a refusal of a unit that
/// is not SI. The first part is never a unit.
Parsed<std::string> canonical_kind(std::string_view kind);

}  // namespace binnacle::spec
