// SPDX-License-Identifier: Apache-2.0
// Decompositions of real matrices behind plain signatures. The numbers are those of Eigen's classes of dynamic size.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

namespace binnacle::algebra {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A = L Lᵀ of a symmetric positive definite matrix (Eigen::LLT). If it is not positive definite, is_positive() is false
/// and the other functions return numbers without meaning.
class Cholesky {
 public:
  explicit Cholesky(const MatrixXd& A);

  bool is_positive() const;
  /// A lower bound of the reciprocal condition number, as Eigen estimates it.
  double rcond() const;
  MatrixXd L() const;
  double log_determinant() const;
  /// A⁻¹ B.
  MatrixXd solve(const MatrixXd& B) const;
  VectorXd solve_vector(const VectorXd& b) const;
  /// L⁻¹ B.
  MatrixXd solve_L(const MatrixXd& B) const;
  VectorXd solve_L_vector(const VectorXd& b) const;
  /// L B.
  MatrixXd times_L(const MatrixXd& B) const;

 private:
  Eigen::LLT<MatrixXd> factor_;
};

/// A = L D Lᵀ of a symmetric matrix, with pivots (Eigen::LDLT).
template <class Matrix>
class PivotedCholeskyOf {
 public:
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Matrix::MaxRowsAtCompileTime, 1>;
  explicit PivotedCholeskyOf(const Matrix& A);

  bool is_factored() const;
  /// Elements of D, in the order of the pivots.
  Vector D() const;
  /// A⁻¹ B.
  Matrix solve(const Matrix& B) const;
  Vector solve_vector(const Vector& b) const;

 private:
  Eigen::LDLT<Matrix> factor_;
};
using PivotedCholesky = PivotedCholeskyOf<MatrixXd>;

/// At most 8 rows, on the stack.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 8, 8>;
using SmallPivotedCholesky = PivotedCholeskyOf<SmallMatrix>;

class LeastSquares {
 public:
  explicit LeastSquares(const MatrixXd& A);

  /// The X of least norm among those of least |A X - B|.
  MatrixXd solve(const MatrixXd& B) const;
  VectorXd solve_vector(const VectorXd& b) const;

 private:
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor_;
};

/// Eigenvalues in ascending order, and an orthonormal eigenvector in each column.
struct Spectrum {
  VectorXd values;
  MatrixXd vectors;
};
/// Spectrum of a symmetric matrix (Eigen::SelfAdjointEigenSolver).
Spectrum spectrum(const MatrixXd& A);
VectorXd eigenvalues(const MatrixXd& A);
/// A v = λ B v with A symmetric and B symmetric positive definite; vᵀ B v = 1.
Spectrum generalized_spectrum(const MatrixXd& A, const MatrixXd& B);

/// A⁻¹ by LU with partial pivots.
MatrixXd inverse(const MatrixXd& A);
/// A⁻¹ b by LU with partial pivots.
VectorXd solve(const MatrixXd& A, const VectorXd& b);
/// e^A by scaling and squaring (Higham 2005; Eigen's MatrixFunctions).
MatrixXd exponential(const MatrixXd& A);
/// B with B Bᵀ = A of a symmetric positive semidefinite matrix.
MatrixXd root(const MatrixXd& A);
/// B with B H = I: of a square H its inverse, else the weighted mean (Hᵀ R⁻¹ H)⁻¹ Hᵀ R⁻¹. Rows of H that are zero have no
/// part in it. Empty if H does not determine it.
MatrixXd left_inverse(const MatrixXd& H, const MatrixXd& R);

/// A = U diag(s) Vᵀ of 3×3, singular values descending.
struct SingularValues {
  Matrix3d U, V;
  Eigen::Vector3d s;
  /// det U det V, so 1 or −1.
  double handedness() const;
  /// The rotation R with the largest trace of Rᵀ A (Wahba's problem; Markley 1988).
  Matrix3d nearest_rotation() const;
};
SingularValues singular_values(const Matrix3d& A);

}  // namespace binnacle::algebra
