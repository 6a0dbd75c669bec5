// SPDX-License-Identifier: Apache-2.0
// "reference", and "implied_states" of the filters.
#pragma once

#include "plan.hpp"

namespace binnacle::score {

void read_implied_states(const CompositionDraft& draft, ScorePlan& plan);
/// After read_implied_states(), which references may be of.
void read_references(CompositionDraft& draft, ScorePlan& plan);

}  // namespace binnacle::score
