// SPDX-License-Identifier: Apache-2.0
// Channels for `inspect`: of bare files, or of a config's sources.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "binnacle/config.hpp"
#include "inspect/channel.hpp"

namespace binnacle::command {

/// Asked now and then while sources are read; false: what came so far is what there is.
using GoesOn = std::function<bool()>;

/// One config (.json), or data files. Text files of `csv` sources are read row by row, so that what the source refuses is seen;
/// any other source emits what it emits. Throws UsageError where both are mixed.
std::vector<inspect::Channel> channels_of(const std::vector<std::string>& files, const LoadOptions& options,
                                          const GoesOn& goes_on);

/// Of a config whatever it is called: LoadOptions may have its text.
std::vector<inspect::Channel> channels_of_config(const std::string& path, LoadOptions options, const GoesOn& goes_on);

}  // namespace binnacle::command
