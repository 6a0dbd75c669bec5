// SPDX-License-Identifier: Apache-2.0
// Smoothing that the config does not ask for.
#pragma once

#include <filesystem>

#include "binnacle/config.hpp"

namespace binnacle::command {

/// Each filter gets a smoother that has none.
void add_smoothers(const std::filesystem::path& config, LoadOptions& options);

}  // namespace binnacle::command
