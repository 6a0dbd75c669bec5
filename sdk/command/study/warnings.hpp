// SPDX-License-Identifier: Apache-2.0
// What `check` says of a config.
#pragma once

#include <filesystem>

#include "binnacle/config.hpp"

namespace binnacle::command {

/// Of a config; of a study or a covariance analysis, of every variant with its metrics and tables, and not of the config
/// without any. Throws as Composition::load does.
Diagnostics warnings_of(const std::filesystem::path& path, const LoadOptions& options);

}  // namespace binnacle::command
