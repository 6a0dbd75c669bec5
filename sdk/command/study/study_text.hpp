// SPDX-License-Identifier: Apache-2.0
// The figures of a study as tables for people.
#pragma once

#include <string>

#include "output.hpp"
#include "study/study.hpp"

namespace binnacle::command {

/// Every metric over the variants, NEES and NIS with their χ² bands, then the tables that the config declares.
std::string study_text(const Json& summary, const study::Study& study);

/// The line below: how many runs, of which seed, and the wall time, which `timed` has beside the figures.
std::string study_end_text(const Json& timed, const study::Study& study);

/// The tables alone.
std::string tables_text(const Json& summary, const study::Study& study);

}  // namespace binnacle::command
