// SPDX-License-Identifier: Apache-2.0
// Channels for `inspect`: of bare files, or of a config's sources.
#pragma once

#include <string>
#include <vector>

#include "inspect/channel.hpp"
#include "verbs.hpp"

namespace binnacle::command {

bool is_config(const std::string& file);

/// One config (.json), or data files. Text files of `csv` sources are read row by row, so that what the source refuses is seen;
/// any other source emits what it emits. Throws UsageError where both are mixed.
std::vector<inspect::Channel> channels_of(const std::vector<std::string>& files, const ConfigOptions& options);

}  // namespace binnacle::command
