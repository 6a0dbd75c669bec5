// SPDX-License-Identifier: Apache-2.0
// Workers: the runs of a study on the processors of one machine.
#pragma once

#include <cstddef>
#include <functional>

#include "study/study.hpp"

namespace binnacle::study {

/// Called for every run that ended, by one thread at a time, in the order in which they end.
using OnRun = std::function<void(std::size_t variant, std::size_t run, const Figures& figures)>;

/// Carries out every run that is still open, run by run through all variants, and enters it by its place: what the
/// results hold at the end does not depend on `jobs`. Ends early, leaving runs open, once `goes_on` says false. What
/// `on_run` throws ends the work and is thrown on.
void carry_out_all(const Study& study, Results& results, int jobs, const std::function<bool()>& goes_on,
                   const OnRun& on_run);

/// How many runs are at work at one time unless told otherwise.
int processors();

}  // namespace binnacle::study
