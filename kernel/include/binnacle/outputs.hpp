// SPDX-License-Identifier: Apache-2.0
// Standard deviations of a block's readable outputs.
#pragma once

#include <cstddef>

#include "binnacle/composition.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// Doubles of scratch that output_sigmas() needs.
std::size_t output_sigma_scratch(const BlockInfo& block);

/// sqrt(diag(J P Jᵀ)) with J = ∂outputs/∂δ by central differences on the block's manifold. x: the block's stored
/// state; P: the filter's covariance, or any whose rows from block.first_row on are the block's active components.
void output_sigmas(const BlockInfo& block, const double* x, MatrixView P, double* scratch, double* sigmas);

}  // namespace binnacle
