// SPDX-License-Identifier: Apache-2.0
// The plugin that Python itself brings: arrays as sources and sinks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "binnacle/catalog.hpp"
#include "binnacle/config.hpp"

namespace binnacle::python {

/// Its types are in the config's text by name only where it wants them: without them a composition is that of the command, and
/// takes the command's snapshots and checkpoints.
bool wants_arrays(const std::string& config_text);
std::vector<std::shared_ptr<const LinkedPlugin>> linked_plugins();

}  // namespace binnacle::python
