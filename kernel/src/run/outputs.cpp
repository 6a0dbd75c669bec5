// SPDX-License-Identifier: Apache-2.0
#include "binnacle/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace binnacle {

std::size_t output_sigma_scratch(const BlockInfo& block) {
  const auto outputs = block.declaration->outputs.size();
  const auto dof = static_cast<std::size_t>(block.declaration->dof());
  return dof + static_cast<std::size_t>(block.declaration->stored_size) + 2 * outputs + outputs * dof;
}

void output_sigmas(const BlockInfo& block, const double* x, MatrixView P, double* scratch, double* sigmas) {
  const auto& declaration = *block.declaration;
  const int outputs = static_cast<int>(declaration.outputs.size());
  const int active = static_cast<int>(block.active.size());
  const ConstVectorView at(x, declaration.stored_size);
  const VectorView delta(scratch, declaration.dof());
  const VectorView moved(delta.data() + delta.size(), declaration.stored_size);
  const VectorView above(moved.data() + moved.size(), outputs), below(above.data() + outputs, outputs);
  double* const J = below.data() + outputs;  // outputs × active
  delta.as().setZero();
  for (int a = 0; a < active; ++a) {
    const int component = block.active[static_cast<std::size_t>(a)];
    const double sigma = std::sqrt(std::max(0.0, P(block.first_row + a, block.first_row + a)));
    // A step of the size of the uncertainty itself, but small against the curvature of an angle.
    const double step = std::clamp(sigma, 1e-9, 1e-4);
    delta[component] = step;
    block.block->plus(at, delta, moved);
    block.block->read(moved, above);
    delta[component] = -step;
    block.block->plus(at, delta, moved);
    block.block->read(moved, below);
    delta[component] = 0;
    for (int i = 0; i < outputs; ++i) {
      double difference = above[i] - below[i];
      if (declaration.outputs[static_cast<std::size_t>(i)].is_angle)
        difference = std::remainder(difference, 2 * std::numbers::pi);
      J[i + a * outputs] = difference / (2 * step);
    }
  }
  for (int i = 0; i < outputs; ++i) {
    double variance = 0;
    for (int a = 0; a < active; ++a)
      for (int b = 0; b < active; ++b)
        variance += J[i + a * outputs] * P(block.first_row + a, block.first_row + b) * J[i + b * outputs];
    sigmas[i] = std::sqrt(std::max(0.0, variance));
  }
}

}  // namespace binnacle
