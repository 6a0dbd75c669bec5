// SPDX-License-Identifier: Apache-2.0
// Results that run or study left in a folder, for verbs that read them.
#pragma once

#include <filesystem>

#include "results/results.hpp"

namespace binnacle::command {

/// Throws OutputError where they are missing or damaged.
results::Results read_results(const std::filesystem::path& folder);
/// The run there; OutputError where there is a study alone.
results::RunResults read_run(const std::filesystem::path& folder);

}  // namespace binnacle::command
