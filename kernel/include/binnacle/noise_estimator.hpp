// SPDX-License-Identifier: Apache-2.0
// NoiseEstimator: how far a measurement is trusted.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/declaration.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/result.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// What the estimator is bound to: the largest row count, and the groups of rows (the parts of a stack, or one).
struct NoiseBinding {
  int max_rows = 0;
  std::vector<NamedUnit> groups;  // name and unit of its rows
};

/// What a bound noise estimator remembers, whether it looks back, and by which R a sample is judged:
///
///     rows_ = declaration_.wants_after().keeps_array<Row>(noise.max_rows);
struct NoiseDeclaration : MemoryDeclaration {
  bool looks_back = false;
  bool is_judged_by_nominal = false;

  /// after() is called.
  NoiseDeclaration& wants_after() {
    looks_back = true;
    return *this;
  }
  /// The estimate is of one sample and for its correction only (the weight of a robust loss): gate, recovery, NIS and the
  /// verdict's monitors keep to the nominal R. estimate() is called once for a sample that passed the gate, with the rows
  /// that passed. Otherwise the estimate is what R is, for all of them, and estimate() comes before the gate.
  NoiseDeclaration& judged_by_nominal() {
    is_judged_by_nominal = true;
    return *this;
  }
};

/// One innovation as an estimator sees it.
struct Innovation {
  Time t = no_time;
  double dt = 0;  // since this measurement's last accepted sample [s]; 0 at the first
  int rows = 0;
  std::span<const std::int64_t> row_keys;
  std::span<const int> row_groups;  // whose row it is: index into NoiseBinding::groups, ascending
  ConstVectorView residual;         // r, before the update: rows
  ConstMatrixView HPHt;             // H P⁻ Hᵀ: rows × rows
  ConstMatrixView R_nominal;        // rows × rows
  MemoryView memory;
  Notes notes;
};

/// What an update left.
struct AfterUpdate {
  Outcome outcome = Outcome::accepted;
  ConstVectorView residual;  // post-fit: r − H δ
  ConstMatrixView HPHt;      // H P⁺ Hᵀ
  MemoryView memory;
};

/// Replaces the nominal R by an estimate. Its memory is rolled back when the sample is gated, unless the config says
/// `learn_from_gated`. Its constructor takes (const Binding&, const NoiseBinding&).
class NoiseEstimator : public DeclaredModel<NoiseDeclaration> {
 public:
  /// Writes R (rows × rows, symmetric, positive semidefinite); it holds R_nominal on entry.
  virtual void estimate(const Innovation& in, MatrixView R) const = 0;
  /// After the update, where the declaration wants_after().
  virtual void after(const AfterUpdate& /*in*/) const {}
};

}  // namespace binnacle
