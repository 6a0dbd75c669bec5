// SPDX-License-Identifier: Apache-2.0
// Calls of blocks outside a filter's own run: when it is scored, and in a covariance analysis.
#pragma once

#include <exception>
#include <string>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/plugin_call.hpp"
#include "binnacle/time.hpp"

namespace binnacle::score {

/// Runs `act`, which calls the block, as the plugin call that is under way: a watchdog names it, and what it throws becomes a
/// FilterError (B045) that names plugin, component, block, call and time.
template <class Act>
auto call_block(const BlockInfo& block, const char* call, Time t, Act&& act) {
  CallSite site;
  site.enter(nullptr, block.type, call);
  site.set_time(t);
  const CallScope scope(site);
  const auto thrown = [&](const char* what) {
    return FilterError(
        Diagnostic{Severity::error, "B045", {}, "", site.text() + " for block '" + block.name + "' threw: " + what});
  };
  try {
    return act();
  } catch (const std::exception& error) {
    throw thrown(error.what());
  } catch (...) {
    throw thrown("something that is no std::exception");
  }
}

}  // namespace binnacle::score
