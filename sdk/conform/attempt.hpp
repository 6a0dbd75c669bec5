// SPDX-License-Identifier: Apache-2.0
// One check, and what becomes of what it throws.
#pragma once

#include <functional>
#include <string>

#include "check.hpp"

namespace binnacle::conform {

/// Runs the check; whatever it throws becomes a failure of the trial, or a skip. stage(): what is being called, "" between
/// calls.
void attempt(const Check& check, Trial& trial, const std::function<std::string()>& stage,
             const std::function<void(const Skip&)>& skipped);

}  // namespace binnacle::conform
