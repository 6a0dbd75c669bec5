// SPDX-License-Identifier: Apache-2.0
// Folders that a verb writes into.
#pragma once

#include <filesystem>

namespace binnacle::command {

/// Makes the folder and those above it; the topmost one made, or "". Throws UsageError.
std::filesystem::path make_folders(const std::filesystem::path& folder);

}  // namespace binnacle::command
