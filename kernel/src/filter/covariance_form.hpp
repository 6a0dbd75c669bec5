// SPDX-License-Identifier: Apache-2.0
// What an estimator asks of its covariance, whatever form that is kept in.
#pragma once

#include "binnacle/view.hpp"
#include "filter/covariance.hpp"

namespace binnacle::filter {

/// P of n rows. Nobody else touches its memory, which lies in the arena and is all that a form remembers.
class CovarianceForm {
 public:
  virtual ~CovarianceForm() = default;

  /// P: n×n.
  virtual void set(MatrixView P) = 0;
  /// P ← Φ P Φᵀ + Qd, by tables of block pointers.
  virtual void predict(const double* const* phi, const double* const* noise) = 0;
  /// work.G = P Hᵀ and work.HPHt = H G of m rows; `columns` of P are those of work.H.
  virtual void project(const std::vector<int>& columns, int m, const UpdateWork& work) const = 0;
  /// P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ with work.K, in which rows of considered components are zero, and work.G and S.
  virtual void correct(int m, const UpdateWork& work) = 0;
  /// P ← T P Tᵀ, where T is the identity but for a d×d block (column-major) at row `first`.
  virtual void transform(const double* T, int first, int d) = 0;
  /// Adds a variance to one component.
  virtual void inflate(int row, double variance) = 0;

  virtual double variance(int row) const = 0;
  /// The first row whose variance is not in [0, bound); −1: all are.
  virtual int first_unsound(double bound) const = 0;
  /// Writes P, n×n.
  virtual void expand(MatrixView into) const = 0;
  /// P to be read until it changes.
  virtual MatrixView view() const = 0;
};

}  // namespace binnacle::filter
