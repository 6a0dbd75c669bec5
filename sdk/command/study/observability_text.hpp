// SPDX-License-Identifier: Apache-2.0
// What can be observed in a run as tables for people.
#pragma once

#include <string>

#include "output.hpp"

namespace binnacle::command {

/// filters: as observe::Observability::figures() gives them.
std::string observability_text(const Json& filters);

}  // namespace binnacle::command
