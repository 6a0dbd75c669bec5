// SPDX-License-Identifier: Apache-2.0
// A run and a study in one folder, of different configs: the page shows both, so it is named.
#pragma once

#include <filesystem>

#include "output.hpp"

namespace binnacle::command {

/// A note to stderr where `folder`, into which a run of `config` was written, holds a study of another config.
void name_other_study(const std::filesystem::path& folder, const Json& study, const Json& config);
/// The same for a study that was written beside a run.
void name_other_run(const std::filesystem::path& folder, const Json& config);

}  // namespace binnacle::command
