// SPDX-License-Identifier: Apache-2.0
// numbers.process.consistency: a filter that believes the model, on a world that is the model.
#pragma once

#include "fixture.hpp"

namespace binnacle::conform {

void process_consistency(Trial& trial);

}  // namespace binnacle::conform
