// SPDX-License-Identifier: Apache-2.0
// A study as results, to be written or handed on.
#pragma once

#include <string>

#include "output.hpp"
#include "results/results.hpp"
#include "study/study.hpp"

namespace binnacle::command {

/// What study.nc holds. Nothing of it depends on when, where to, or by how many workers it was made.
results::StudyResults study_results(const study::Study& study, const study::Results& results, const Json& figures,
                                    const Json& config, const std::string& command);

}  // namespace binnacle::command
