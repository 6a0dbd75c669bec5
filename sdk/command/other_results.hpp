// SPDX-License-Identifier: Apache-2.0
// A run and a study in one folder, of different configs: the page shows both, so it is named.
#pragma once

#include <filesystem>

#include "output.hpp"

namespace binnacle::command {

/// A note to stderr where the folder, into which a run of that config was written, holds a study of another one.
void name_other_study(const std::filesystem::path& folder, const Json& config);
/// The same of a study that was written beside a run.
void name_other_run(const std::filesystem::path& folder, const Json& config);

}  // namespace binnacle::command
