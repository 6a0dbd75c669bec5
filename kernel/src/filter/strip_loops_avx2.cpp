// SPDX-License-Identifier: Apache-2.0
// StripLoops for AVX2: four doubles to a register. Compiled with -mavx2 where there is such a flag.
#ifdef __AVX2__

namespace binnacle {
namespace {
constexpr int lanes = 4;
}
}  // namespace binnacle

#include "filter/strip_loops_body.hpp"

const binnacle::StripLoops binnacle::avx2_strip_loops = {combine, correct_lower};

#else

#include "filter/strip_loops.hpp"

const binnacle::StripLoops binnacle::avx2_strip_loops = {nullptr, nullptr};

#endif
