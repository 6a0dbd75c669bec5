// SPDX-License-Identifier: Apache-2.0
// Loading one plugin file: checks before, guard, dlopen, registration.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "binnacle/catalog.hpp"

namespace binnacle::plugin {

struct LoadedPlugin {
  PluginInfo info;
  std::vector<ComponentType> types;  // in the order of registration
};

/// Nothing, with errors in the diagnostics, when it is refused. `accept` is asked for the plugin's name before its code
/// is loaded; it reports what it has against it.
std::optional<LoadedPlugin> load_plugin(const std::filesystem::path& file, Diagnostics& diagnostics,
                                        const std::function<bool(const PluginInfo&)>& accept);

}  // namespace binnacle::plugin
