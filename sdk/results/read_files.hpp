// SPDX-License-Identifier: Apache-2.0
// One file of results; what is wrong with it is an nc::Failure without its name.
#pragma once

#include "netcdf.hpp"
#include "results/results.hpp"

namespace binnacle::results {

/// Without its summary.
RunResults read_run(const nc::File& file);
/// Without its figures.
StudyResults read_study(const nc::File& file);

}  // namespace binnacle::results
