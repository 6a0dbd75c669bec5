// SPDX-License-Identifier: Apache-2.0
// StripLoops for AVX2: four doubles to a register. Compiled with -mavx2 where there is such a flag.
#ifdef __AVX2__

namespace binnacle::filter {
namespace {
constexpr int lanes = 4;
}
}  // namespace binnacle::filter

#include "filter/strip_loops_body.hpp"

const binnacle::filter::StripLoops binnacle::filter::avx2_strip_loops = {combine, combine_neighbours, transpose,
                                                                         mirror,  gain_columns,       correct_lower};

#else

#include "filter/strip_loops.hpp"

const binnacle::filter::StripLoops binnacle::filter::avx2_strip_loops = {};

#endif
