// SPDX-License-Identifier: Apache-2.0
// NEES: of a block, and of the whole state.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/view.hpp"
#include "series.hpp"

namespace binnacle::score {

/// δᵀ P⁻¹ δ by Cholesky. L holds the lower triangle of P, n×n by columns, and is overwritten; y has room for n. Nothing
/// where a pivot is not above `least` times its diagonal: P is singular.
std::optional<double> regular_nees(double* L, const double* delta, double* y, int n, double least);

struct RankedNees {
  double nees = 0;
  int rank = 0;
};
/// δᵀ P⁺ δ of a P that is symmetric, n×n, and may be singular: of the correlations, eigenvalues below n ε times the largest
/// are no degrees of freedom. Along them the error must be none; one that is there is divided by that bound, so a truth
/// that P rules out makes the NEES very large.
RankedNees ranked_nees(const double* P, const double* delta, int n);

/// NEES of all components with a variance of all blocks that references give in full, cross-covariances included, at each
/// epoch that gives all of these blocks. Considered components have a variance and count; frozen ones have none.
class StateNees {
 public:
  /// Before the run: where the block's error is to be given, −1 where it has no component with a variance.
  int add(const BlockInfo& block);
  /// δ of a block, all components of it. P is the filter's. `changes` tells estimates of one time apart.
  void take(int part, Time t, std::int64_t changes, const double* delta, ConstMatrixView P);

  /// Names of the blocks.
  std::vector<std::string> blocks() const;
  bool is_there() const { return !parts_.empty(); }
  const Series& nees() const { return nees_; }
  /// The degrees of freedom of each: the rank of P.
  const Series& dof() const { return dof_; }
  void exchange(StateBytes& bytes);

 private:
  struct Part {
    const BlockInfo* block = nullptr;
    int first = 0;  // of its components in delta_
    bool is_given = false;
  };
  void evaluate(ConstMatrixView P);

  std::vector<Part> parts_;
  std::size_t given_ = 0;
  Time t_ = no_time;
  std::int64_t changes_ = 0;
  std::vector<int> rows_;  // of P, by component
  std::vector<double> delta_, P_, L_, y_;
  Series nees_{"state.nees", "1", "1", {}, {}}, dof_{"state.dof", "1", "1", {}, {}};
};

}  // namespace binnacle::score
