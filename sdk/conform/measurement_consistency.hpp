// SPDX-License-Identifier: Apache-2.0
// numbers.measurement.consistency: the normalized innovations of a filter that believes the model.
#pragma once

#include "fixture.hpp"

namespace binnacle::conform {

void measurement_consistency(Trial& trial);

}  // namespace binnacle::conform
