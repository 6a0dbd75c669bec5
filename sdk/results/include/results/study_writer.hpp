// SPDX-License-Identifier: Apache-2.0
// A study as a NetCDF-4 file.
#pragma once

#include <filesystem>

#include "results/results.hpp"

namespace binnacle::results {

/// Replaces what is at `path`. The same results make the same bytes. Throws WriteError.
void write_study(const std::filesystem::path& path, const StudyResults& study);

}  // namespace binnacle::results
