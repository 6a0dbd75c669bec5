// SPDX-License-Identifier: Apache-2.0
// The verdict on a run that is over.
#pragma once

#include "score/run.hpp"

namespace binnacle::score {

/// At the end of a run: a filter that never started is lost.
Verdict final_verdict(const Session& session, FilterId filter);

}  // namespace binnacle::score
