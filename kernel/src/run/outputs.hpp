// SPDX-License-Identifier: Apache-2.0
// Readable outputs of a block and their standard deviations.
#pragma once

#include <cstddef>

#include "filter/plan.hpp"

namespace binnacle {

/// Doubles of scratch that output_sigmas() needs.
std::size_t output_sigma_scratch(const filter::BlockPlan& block);

/// sqrt(diag(J P Jᵀ)) with J = ∂outputs/∂δ by central differences on the block's manifold. x: the block's stored
/// state; P: the filter's covariance.
void output_sigmas(const filter::BlockPlan& block, const double* x, MatrixView P, double* scratch, double* sigmas);

}  // namespace binnacle
