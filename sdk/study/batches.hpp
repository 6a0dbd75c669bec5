// SPDX-License-Identifier: Apache-2.0
// The work of a study in pieces, for so many workers.
#pragma once

#include <cstddef>
#include <vector>

#include "study/workers.hpp"

namespace binnacle::study {

/// Variants of a batch, at most: each has its memory while a batch is at work, and sixteen leave a sixteenth of the cost of
/// samples to each.
constexpr std::size_t most_together = 16;

/// What is still open, run by run; of each run the largest batches first. Where the last round has fewer batches than there
/// are workers, its batches are cut into parts for all of them.
std::vector<Batch> batches_of(const std::vector<std::vector<std::size_t>>& groups, const Results& results, int workers);

}  // namespace binnacle::study
