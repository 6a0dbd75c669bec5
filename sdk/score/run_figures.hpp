// SPDX-License-Identifier: Apache-2.0
// The verdict on a run that is over.
#pragma once

#include "bias_effects.hpp"
#include "jump_watch.hpp"
#include "score/run.hpp"
#include "score/verdict.hpp"

namespace binnacle::score {

/// "verdict" of run_figures(), with the sizes of reasons and the limits applied. Null: what was not followed.
nlohmann::ordered_json sized_verdict(const Session& session, FilterId filter, const BiasEffects* effects,
                                     const JumpWatch* jumps, const Limits& limits);

/// As run_figures() in score/run.hpp, with this verdict.
nlohmann::ordered_json run_figures(const Session& session, FilterId filter, nlohmann::ordered_json verdict);

/// Session::doubts() of the filter that are reasons in its sized verdict.
Diagnostics doubts(const Session& session, FilterId filter, const nlohmann::ordered_json& verdict);

}  // namespace binnacle::score
