// SPDX-License-Identifier: Apache-2.0
// Calls of blocks outside a filter's own run: when it is scored, smoothed, and in a covariance analysis.
#pragma once

#include <string>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/plugin_call.hpp"
#include "binnacle/time.hpp"

namespace binnacle::wording {

/// Runs `act`, which calls the block, as the plugin call that is under way: a watchdog names it, and what it throws becomes a
/// FilterError (B045) that names plugin, component, block, call and time.
template <class Act>
auto call_block(const BlockInfo& block, const char* call, Time t, Act&& act) {
  return call_plugin(nullptr, block.type, call, t, std::forward<Act>(act), [&](std::string text) {
    // "… threw: what": the block goes between.
    return FilterError(Diagnostic{Severity::error, "B045", {}, "", "block '" + block.name + "': " + text});
  });
}

}  // namespace binnacle::wording
