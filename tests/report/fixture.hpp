// SPDX-License-Identifier: Apache-2.0
// Results made by hand: a run with everything that a page shows, and a study.
#pragma once

#include <cstddef>
#include <string>

#include "results/results.hpp"

namespace binnacle::test {

/// A drive in turns: position with lat and lon, its errors, NEES, a bias, fixes of which some are gated, adapted noise.
results::Results run_results(const std::string& filter, std::size_t samples);

/// Two variants, one metric with a table and the paper's figures, one run that broke.
results::Results study_results();

}  // namespace binnacle::test
