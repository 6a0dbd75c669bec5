// SPDX-License-Identifier: Apache-2.0
// Where results come from: attributes and variables at the root of every file.
#pragma once

#include <string>

#include "netcdf.hpp"
#include "results/results.hpp"

namespace binnacle::results {

/// Raised when what is in a file moves or changes its meaning.
inline constexpr std::int64_t layout = 1;

/// `kind`: "run" or "study".
void write_provenance(nc::Group root, const std::string& kind, const Json& config, const Json& provenance);
/// What write_provenance() was given. Throws nc::Failure where the file is none of ours, or of another layout.
void read_provenance(nc::Group root, const std::string& kind, Json& config, Json& provenance);

}  // namespace binnacle::results
