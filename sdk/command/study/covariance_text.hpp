// SPDX-License-Identifier: Apache-2.0
// The figures of a covariance analysis as tables for people.
#pragma once

#include <string>

#include "output.hpp"
#include "study/study.hpp"

namespace binnacle::command {

/// Every metric over the variants, the tables that the config declares, and what the final variances come of.
std::string covariance_text(const Json& summary, const study::Study& study, bool has_budget);

}  // namespace binnacle::command
