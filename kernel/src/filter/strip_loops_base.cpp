// SPDX-License-Identifier: Apache-2.0
// StripLoops for every processor that this program was built for.
#include "filter/strip_loops_body.hpp"

const binnacle::internal::filter::StripLoops binnacle::internal::filter::base_strip_loops = loops;
