// SPDX-License-Identifier: Apache-2.0
// The config reference: every key that there is, as one Markdown page made from the specs.
#pragma once

#include <string>

#include "binnacle/catalog.hpp"

namespace binnacle::command {

/// The kernel's own keys, then every component type by role.
std::string reference_page(const Catalog& catalog);

}  // namespace binnacle::command
