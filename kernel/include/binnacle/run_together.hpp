// SPDX-License-Identifier: Apache-2.0
// run_together: compositions that differ in their filters, over samples that are made once for all of them.
#pragma once

#include <exception>
#include <memory>
#include <span>
#include <vector>

#include "binnacle/run.hpp"

namespace binnacle {

/// Whether all sources of both give the same samples, in every run: of the same types of the same plugins at the same places
/// of the config, with the same parameters and latencies as resolved. Never where one is live.
bool have_same_sources(const Composition& a, const Composition& b);

/// From now on, sources that are the same in several of them are one object: its data are read once. Before their first run.
void share_sources(std::span<const std::shared_ptr<const Composition>> compositions);

/// One of the runs of run_together().
struct RunRequest {
  std::shared_ptr<const Composition> composition;
  RunOptions options = {};
};

/// What run() returns, or what it throws.
struct RunOutcome {
  RunResult result;
  std::exception_ptr thrown = nullptr;
};

/// The same as run() of each, to the bit. Every sample is drawn once, and so is what transforms make of it that are the
/// same and depend on nothing else; they run side by side, a stretch of some 64 samples each in turn, so few are kept. All
/// have the same sources, seed and run; none has checkpoints, a pace, recorded input or an observer that runs again.
/// Throws std::invalid_argument where that is not so. What one throws ends that one alone.
std::vector<RunOutcome> run_together(std::span<const RunRequest> requests);

}  // namespace binnacle
