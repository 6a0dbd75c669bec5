// SPDX-License-Identifier: Apache-2.0
// Noise estimators: what they make of an innovation is a covariance.
#include <numeric>

#include "algebra/decompositions.hpp"
#include "guarded.hpp"

namespace binnacle::testing {

namespace {

/// A covariance as an input: a copy whose writing to is found.
ConstMatrixView kept(Inputs& inputs, const char* name, const Eigen::MatrixXd& P) {
  const int rows = static_cast<int>(P.rows());
  return {inputs.keep(name, P.data(), static_cast<std::size_t>(P.size())), rows, rows, rows};
}

}  // namespace

std::vector<std::byte> NoiseCaller::fresh_memory() const {
  std::vector<std::byte> memory(estimator_->declaration().memory_bytes);
  called("start", [&] { return estimator_->start(memory.data()), 0; });
  return memory;
}

Estimated NoiseCaller::estimate(const InnovationNumbers& given, MemoryView memory) const {
  const int rows = static_cast<int>(given.residual.size());
  Inputs inputs;
  Estimated out;
  std::vector<std::int64_t> keys = given.keys;
  std::vector<int> groups = given.groups;
  if (keys.empty()) {
    keys.resize(as_size(rows));
    std::iota(keys.begin(), keys.end(), 0);
  }
  groups.resize(as_size(rows), 0);
  const Innovation innovation{given.t,
                              given.dt,
                              rows,
                              keys,
                              groups,
                              inputs.keep("the residual", ConstVectorView(given.residual)),
                              kept(inputs, "HPHt", given.HPHt),
                              kept(inputs, "R_nominal", given.R_nominal),
                              memory,
                              {&out.notes, [](void* notes, const char* text) {
                                 static_cast<std::vector<std::string>*>(notes)->emplace_back(text);
                               }}};
  Guarded R(as_size(rows * rows), 0.0);
  matrix_at(R.data(), rows, rows) = given.R_nominal;
  called("estimate", [&] { return estimator_->estimate(innovation, {R.data(), rows, rows, rows}), 0; });
  out.R = matrix_at(R.data(), rows, rows);
  if (estimator_->declaration().looks_back) {
    // Of an accepted sample: r - H K r = R S^-1 r, and H P+ H' = M - M S^-1 M, with the R that it gave.
    const algebra::PivotedCholesky S(given.HPHt + out.R);
    const Eigen::VectorXd residual = out.R * S.solve_vector(given.residual);
    const Eigen::MatrixXd left = given.HPHt - given.HPHt * S.solve(given.HPHt);
    const AfterUpdate after{Outcome::accepted, inputs.keep("the post-fit residual", ConstVectorView(residual)),
                            kept(inputs, "HPHt after the update", left), memory};
    called("after", [&] { return estimator_->after(after), 0; });
  }
  out.damage = inputs.damage("estimate");
  if (!R.is_intact()) out.damage = "R: written beyond its end";
  return out;
}

Complaints check_noise(const NoiseCaller& noise, const InnovationNumbers& innovation, MemoryView memory) {
  Complaints out;
  const Estimated estimated = noise.estimate(innovation, memory);
  if (!estimated.damage.empty()) out.add(estimated.damage);
  if (!estimated.R.allFinite())
    out.add("R is not finite:\n", estimated.R);
  else
    out.add_all(check_covariance(estimated.R));
  return out;
}

}  // namespace binnacle::testing
