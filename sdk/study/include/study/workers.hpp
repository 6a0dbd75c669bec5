// SPDX-License-Identifier: Apache-2.0
// Workers: the runs of a study on the processors of one machine.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "study/study.hpp"

namespace binnacle::study {

/// One run of one variant.
struct RunKey {
  std::size_t variant = 0;
  std::size_t run = 0;
};

/// One run of variants that draw the same samples.
struct Batch {
  std::vector<std::size_t> variants;
  std::size_t run = 0;
};

/// Called for every run that ended, by one thread at a time, in the order in which they end.
using OnRun = std::function<void(std::size_t variant, std::size_t run, const Figures& figures)>;

/// Carries out every run that is still open, run by run through all variants, and enters it by its place: what the
/// results hold at the end does not depend on `jobs`. Ends early, leaving runs open, once `goes_on` says false. What
/// `on_run` throws ends the work and is thrown on.
void carry_out_all(const Study& study, Results& results, int jobs, const std::function<bool()>& goes_on,
                   const OnRun& on_run);

/// What came of the batch's variants, in their order.
using OnBatch = std::function<void(const Batch& batch, std::vector<Figures>&& figures)>;

/// The heart of it: `jobs` threads ask for the next batch, which may take its time, and hand over what came of it. They end
/// when there is none, or `goes_on` says false. What `done` throws is thrown on; it has to make `goes_on` say false.
void carry_out_runs(const Study& study, int jobs, const std::function<std::optional<Batch>()>& next,
                    const OnBatch& done, const std::function<bool()>& goes_on);

/// Works on 0 … count − 1 with that many threads, or as many as the system gives; what it throws is thrown on. May be called
/// inside `work`: all together take no more.
void in_parallel(int jobs, std::size_t count, const std::function<void(std::size_t)>& work);

/// How many runs are at work at one time by default, where so many processes share the machine: those bound
/// to processors of their own use these.
int processors(int processes_here = 1);

}  // namespace binnacle::study
