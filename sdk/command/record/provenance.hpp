// SPDX-License-Identifier: Apache-2.0
// Where results come from: version, plugins, the command, the time.
#pragma once

#include <string>

#include "binnacle/catalog.hpp"
#include "output.hpp"

namespace binnacle::command {

/// { "version", "command", "plugins": [ { "name", "version", "path" } ] }. `command`: the one that makes them again.
Json provenance(const Catalog& catalog, const std::string& command);

/// "2026-11-21T08:50:00Z"; that of SOURCE_DATE_EPOCH, where it is set.
std::string now_in_words();

}  // namespace binnacle::command
