// SPDX-License-Identifier: Apache-2.0
// What `binnacle explain` prints.
#pragma once

#include <string>

#include "output.hpp"

namespace binnacle::command {

/// explained: what document::explain() gives; config: as it is resolved.
std::string explanation_text(const Json& explained, const Json& config);

}  // namespace binnacle::command
