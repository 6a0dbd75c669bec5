// SPDX-License-Identifier: Apache-2.0
// Times of results, in seconds. Nothing else is included here: files that are compiled for speed stay cheap to compile.
#pragma once

#include "binnacle/time.hpp"

namespace binnacle::results {

/// The double nearest to the time, so that it equals what is read from a CSV of the same run.
double nearest_seconds(Time t);

}  // namespace binnacle::results
