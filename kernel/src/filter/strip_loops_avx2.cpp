// SPDX-License-Identifier: Apache-2.0
// StripLoops for AVX2. Compiled with -mavx2 where there is such a flag.
#ifdef __AVX2__
#include "filter/strip_loops_body.hpp"

const binnacle::internal::filter::StripLoops binnacle::internal::filter::avx2_strip_loops = loops;
#else
#include "filter/strip_loops.hpp"

const binnacle::internal::filter::StripLoops binnacle::internal::filter::avx2_strip_loops = {};
#endif
