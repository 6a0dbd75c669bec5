// SPDX-License-Identifier: Apache-2.0
// Blocks whose outputs are their value: a record reads them without a call.
#pragma once

#include "binnacle/composition.hpp"

namespace binnacle::score {

/// Whether x ⊞ δ is x + δ and the outputs are x: of vectors and velocities, as far as trying it shows the same.
bool is_plain(const BlockInfo& block);

/// As output_sigmas() of a plain block, to the bit. x: its value; P: the filter's covariance.
void plain_sigmas(const BlockInfo& block, const double* x, ConstMatrixView P, double* sigmas);

}  // namespace binnacle::score
