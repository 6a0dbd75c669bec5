// SPDX-License-Identifier: Apache-2.0
#include "algebra/decompositions.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <unsupported/Eigen/MatrixFunctions>

#include <vector>

namespace binnacle::algebra {

Cholesky::Cholesky(const MatrixXd& A) : factor_(A) {}

bool Cholesky::is_positive() const { return factor_.info() == Eigen::Success; }
double Cholesky::rcond() const { return factor_.rcond(); }
MatrixXd Cholesky::L() const { return factor_.matrixL(); }
double Cholesky::log_determinant() const { return 2 * L().diagonal().array().log().sum(); }
MatrixXd Cholesky::solve(const MatrixXd& B) const { return factor_.solve(B); }
VectorXd Cholesky::solve_vector(const VectorXd& b) const { return factor_.solve(b); }
MatrixXd Cholesky::solve_L(const MatrixXd& B) const { return factor_.matrixL().solve(B); }
VectorXd Cholesky::solve_L_vector(const VectorXd& b) const { return factor_.matrixL().solve(b); }
MatrixXd Cholesky::times_L(const MatrixXd& B) const { return factor_.matrixL() * B; }

template <class Matrix>
PivotedCholeskyOf<Matrix>::PivotedCholeskyOf(const Matrix& A) : factor_(A) {}

template <class Matrix>
bool PivotedCholeskyOf<Matrix>::is_factored() const {
  return factor_.info() == Eigen::Success;
}
template <class Matrix>
typename PivotedCholeskyOf<Matrix>::Vector PivotedCholeskyOf<Matrix>::D() const {
  return factor_.vectorD();
}
template <class Matrix>
Matrix PivotedCholeskyOf<Matrix>::solve(const Matrix& B) const {
  return factor_.solve(B);
}
template <class Matrix>
typename PivotedCholeskyOf<Matrix>::Vector PivotedCholeskyOf<Matrix>::solve_vector(const Vector& b) const {
  return factor_.solve(b);
}
template class PivotedCholeskyOf<MatrixXd>;
template class PivotedCholeskyOf<SmallMatrix>;

LeastSquares::LeastSquares(const MatrixXd& A) : factor_(A) {}

MatrixXd LeastSquares::solve(const MatrixXd& B) const { return factor_.solve(B); }
VectorXd LeastSquares::solve_vector(const VectorXd& b) const { return factor_.solve(b); }

Spectrum spectrum(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd eigenvalues(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Spectrum generalized_spectrum(const MatrixXd& A, const MatrixXd& B) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(A, B);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

MatrixXd inverse(const MatrixXd& A) { return A.inverse(); }

VectorXd solve(const MatrixXd& A, const VectorXd& b) { return A.partialPivLu().solve(b); }

MatrixXd exponential(const MatrixXd& A) { return A.exp(); }

MatrixXd root(const MatrixXd& A) {
  const MatrixXd symmetric = 0.5 * (A + A.transpose());
  const Eigen::LLT<MatrixXd> positive(symmetric);
  if (positive.info() == Eigen::Success) return positive.matrixL();
  const Eigen::LDLT<MatrixXd> semidefinite(symmetric);
  MatrixXd L = semidefinite.matrixL();
  L *= semidefinite.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal();
  return semidefinite.transpositionsP().transpose() * L * semidefinite.transpositionsP();
}

MatrixXd left_inverse(const MatrixXd& H, const MatrixXd& R) {
  std::vector<Eigen::Index> seeing;
  for (Eigen::Index i = 0; i < H.rows(); ++i)
    if (!H.row(i).isZero(0)) seeing.push_back(i);
  if (static_cast<Eigen::Index>(seeing.size()) < H.cols()) return {};
  const MatrixXd seen = H(seeing, Eigen::all);
  const MatrixXd W =
      seen.rows() == seen.cols() ? MatrixXd(seen.inverse()) : MatrixXd(seen.transpose() * R(seeing, seeing).inverse());
  const Eigen::FullPivLU<MatrixXd> lu(W * seen);
  if (!W.allFinite() || !lu.isInvertible()) return {};
  MatrixXd B = MatrixXd::Zero(H.cols(), H.rows());
  B(Eigen::all, seeing) = lu.solve(W);
  return B;
}

double SingularValues::handedness() const { return U.determinant() * V.determinant() > 0 ? 1 : -1; }

Matrix3d SingularValues::nearest_rotation() const {
  return U * Eigen::Vector3d(1, 1, handedness()).asDiagonal() * V.transpose();
}

SingularValues singular_values(const Matrix3d& A) {
  const Eigen::JacobiSVD<Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

}  // namespace binnacle::algebra
