// SPDX-License-Identifier: Apache-2.0
// What component types ask for and give, from their specs: for people, for programs, for editors.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"

namespace binnacle::document {

/// `binnacle describe`: source, ports, fields, parameters with unit, range and default, an example.
std::string describe(const ComponentType& type);
nlohmann::ordered_json describe_json(const ComponentType& type);

/// JSON Schema (draft-07) of a whole config with these types. Full names, and short ones where they are unambiguous.
nlohmann::ordered_json schema(const Catalog& catalog);

/// A config with one component of each type, required parameters to be filled in and the others at their defaults.
std::string skeleton(const std::vector<const ComponentType*>& types);

/// `binnacle explain`, `binnacle graph`: state layout, who moves, reads and couples to whom, channels, what components
/// found out, what is unused; sections add theirs (SectionData::explain).
nlohmann::ordered_json explain(const Composition& composition);

}  // namespace binnacle::document
