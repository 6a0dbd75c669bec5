// SPDX-License-Identifier: Apache-2.0
// What `inspect` found, for people.
#pragma once

#include <string>

#include "inspect/inspect.hpp"

namespace binnacle::command {

std::string inspection_text(const inspect::Inspection& inspection);

}  // namespace binnacle::command
