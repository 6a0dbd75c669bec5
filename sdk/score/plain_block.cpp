// SPDX-License-Identifier: Apache-2.0
#include "plain_block.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "binnacle/state_block.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

/// Of one component moved at a time: the others must stay.
bool adds_up(const BlockInfo& block) {
  const int n = block.declaration->dof();
  std::vector<double> x(as_size(n)), delta(as_size(n)), moved(as_size(n)), outputs(as_size(n));
  for (int i = 0; i < n; ++i) x[as_size(i)] = 0.1 + 1.7 * i;
  for (int component = 0; component < n; ++component)
    for (const double step : {1e-4, -1e-9}) {
      delta[as_size(component)] = step;
      block.block->plus({x.data(), n}, {delta.data(), n}, {moved.data(), n});
      block.block->read({moved.data(), n}, {outputs.data(), n});
      for (std::size_t i = 0; i < as_size(n); ++i)
        if (moved[i] != x[i] + delta[i] || outputs[i] != moved[i]) return false;
      delta[as_size(component)] = 0;
    }
  return true;
}

}  // namespace

bool is_plain(const BlockInfo& block) {
  const auto& declaration = *block.declaration;
  const bool may_be = declaration.kind.starts_with("vector:") || declaration.kind.starts_with("velocity.");
  const auto n = as_size(declaration.dof());
  if (!may_be || as_size(declaration.stored_size) != n || declaration.outputs.size() != n) return false;
  if (std::ranges::any_of(declaration.outputs, [](const Output& output) { return output.is_angle; })) return false;
  try {
    return adds_up(block);
  } catch (...) {
    return false;  // the run reports what it throws
  }
}

void plain_sigmas(const BlockInfo& block, const double* x, ConstMatrixView P, double* sigmas) {
  std::fill_n(sigmas, block.declaration->outputs.size(), 0.0);
  for (std::size_t a = 0; a < block.active.size(); ++a) {
    const int row = block.first_row + static_cast<int>(a), component = block.active[a];
    const double variance = P(row, row);
    // Its root lies beyond what a step may be: no need to take it.
    const double step = variance > 1.001e-8 ? 1e-4 : std::clamp(std::sqrt(std::max(0.0, variance)), 1e-9, 1e-4);
    const double difference = (x[component] + step) - (x[component] - step);
    const double along = difference == 0 ? 0 : difference / (2 * step);
    sigmas[component] = std::sqrt(std::max(0.0, along * variance * along));
  }
}

}  // namespace binnacle::score
