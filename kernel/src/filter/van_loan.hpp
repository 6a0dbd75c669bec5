// SPDX-License-Identifier: Apache-2.0
// Discretization of linear models, jointly where they are coupled through a port.
#pragma once

#include <cstddef>
#include <vector>

#include "binnacle/process_model.hpp"

namespace binnacle::filter {

/// Linear process models whose blocks are coupled: one F, one GQGᵀ, one matrix exponential.
///
/// Rows are the advanced blocks; the columns are those and, after them, blocks that the group only reads. What is read
/// from outside the group is held over the step, so its coupling is exact for a constant and of first order else.
struct VanLoanGroup {
  struct Part {
    int value = 0;  // state block or derived value
    int first = 0;  // row and column of the group's matrices
    int dof = 0;
  };
  struct Block {
    int table = 0;  // index in the filter's table of blocks
    int row = 0;
    int column = 0;
    int rows = 0;
    int columns = 0;
    Structure structure = Structure::dense;
  };
  std::vector<Part> advanced;
  std::vector<Part> read;
  std::vector<Block> dynamics;  // F as the models write it
  std::vector<Block> noise;     // GQGᵀ as the models write it
  std::vector<Block> phi;       // the discrete blocks that are made of them
  std::vector<Block> qd;
  int rows = 0;          // Σ dof of advanced
  int columns = 0;       // rows + Σ dof of read
  std::size_t work = 0;  // offset in the workspace of van_loan_matrices
};

/// In the workspace of a group, columns × columns: F, Q, Phi, Qd, and four that discretize() works with.
inline constexpr std::size_t van_loan_matrices = 8;

/// Φ = exp(F dt) and Qd = ∫ exp(F s) Q exp(F s)ᵀ ds. F, Q, Phi, Qd: n×n column-major, dense; work: four such
/// matrices. By scaling, a Taylor series to full precision, and doubling:
/// Φ(2h) = Φ(h)², Qd(2h) = Qd(h) + Φ(h) Qd(h) Φ(h)ᵀ — the same quantities as Van Loan (1978) eq. 2.13 without the
/// exponential of −F, which overflows for fast stable modes.
void discretize(const double* F, const double* Q, int n, double dt, double* Phi, double* Qd, double* work);

}  // namespace binnacle::filter
