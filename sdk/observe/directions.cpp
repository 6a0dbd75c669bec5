// SPDX-License-Identifier: Apache-2.0
#include "observe/directions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "algebra/decompositions.hpp"

namespace binnacle::observe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Turns columns p and q of A, and of T with them, to the greatest sum of variances of squared loadings. False where they
/// are there already.
bool turn(MatrixXd& A, MatrixXd& T, Index p, Index q) {
  const auto n = static_cast<double>(A.rows());
  const Eigen::ArrayXd u = A.col(p).array().square() - A.col(q).array().square();
  const Eigen::ArrayXd v = 2 * A.col(p).array() * A.col(q).array();
  const double numerator = 2 * ((u * v).sum() - u.sum() * v.sum() / n);
  const double denominator = (u.square() - v.square()).sum() - (u.sum() * u.sum() - v.sum() * v.sum()) / n;
  const double angle = 0.25 * std::atan2(numerator, denominator);
  if (std::abs(angle) < 1e-9) return false;
  const double c = std::cos(angle), s = std::sin(angle);
  for (MatrixXd* B : {&A, &T}) {
    const VectorXd first = B->col(p);
    B->col(p) = c * first + s * B->col(q);
    B->col(q) = c * B->col(q) - s * first;
  }
  return true;
}

/// The rotation that varimax gives for the loadings A.
MatrixXd varimax(MatrixXd A) {
  constexpr int most_sweeps = 200;
  MatrixXd T = MatrixXd::Identity(A.cols(), A.cols());
  bool is_turning = true;
  for (int sweep = 0; is_turning && sweep < most_sweeps; ++sweep) {
    is_turning = false;
    for (Index p = 0; p < A.cols(); ++p)
      for (Index q = p + 1; q < A.cols(); ++q) is_turning = turn(A, T, p, q) || is_turning;
  }
  return T;
}

/// F / σ by rows; zero where nothing is left.
MatrixXd loadings(const MatrixXd& F, const VectorXd& variances) {
  MatrixXd A = MatrixXd::Zero(F.rows(), F.cols());
  for (Index i = 0; i < F.rows(); ++i)
    if (variances[i] > 0) A.row(i) = F.row(i) / std::sqrt(variances[i]);
  return A;
}

/// f: one standard deviation along the direction.
std::vector<Part> parts_of(const VectorXd& f, const VectorXd& before, const VectorXd& left) {
  std::vector<Part> parts;
  Part largest;
  for (Index i = 0; i < f.size(); ++i) {
    if (!(left[i] > 0)) continue;
    const double square = f[i] * f[i];
    const Part part{static_cast<int>(i), f[i], square / left[i], square / before[i]};
    if (part.share > largest.share) largest = part;
    if (part.share > 0.5) parts.push_back(part);
  }
  if (parts.empty()) parts.push_back(largest);
  std::ranges::stable_sort(parts, std::greater<>(), &Part::of_before);
  const double least = 0.01 * parts.front().of_before;
  while (parts.size() > 2 && parts.back().of_before < least) parts.pop_back();
  std::ranges::sort(parts, {}, &Part::row);
  if (parts.front().displacement < 0)
    for (Part& part : parts) part.displacement = -part.displacement;
  return parts;
}

VectorXd variances_before(const MatrixXd& W) { return W.cwiseAbs2().rowwise().sum(); }

void sort(auto& directions) {
  std::ranges::stable_sort(directions, {}, [](const auto& direction) { return direction.parts.front().row; });
}

}  // namespace

VectorXd variances_left(const MatrixXd& W, const MatrixXd& D) {
  const MatrixXd left = MatrixXd::Identity(D.rows(), D.cols()) - D;
  return (W * left).cwiseProduct(W).rowwise().sum().cwiseMax(0);
}

std::vector<double> singular_values(const MatrixXd& D) {
  const VectorXd shares = algebra::eigenvalues(D);
  const double least = static_cast<double>(D.rows()) * std::numeric_limits<double>::epsilon();
  std::vector<double> values;
  for (Index i = D.rows() - 1; i >= 0; --i) {
    const double share = std::clamp(shares[i], 0.0, 1 - least);
    values.push_back(std::sqrt(share / (1 - share)));
  }
  return values;
}

std::vector<Direction> weak_directions(const MatrixXd& W, const MatrixXd& D) {
  const algebra::Spectrum spectrum = algebra::spectrum(D);
  const Index weak = (spectrum.values.array() < known_share).count();
  if (weak == 0) return {};
  const VectorXd left = (1 - spectrum.values.head(weak).array()).sqrt();
  const MatrixXd scaled = spectrum.vectors.leftCols(weak) * left.asDiagonal();
  const VectorXd variances = variances_left(W, D);
  const MatrixXd T = varimax(loadings(W * scaled, variances));
  std::vector<Direction> directions;
  for (Index k = 0; k < weak; ++k) {
    const VectorXd u = scaled * T.col(k);
    directions.push_back({parts_of(W * u, variances_before(W), variances), u.normalized()});
  }
  sort(directions);
  return directions;
}

std::vector<SpuriousDirection> spurious_directions(const MatrixXd& W, const MatrixXd& claimed,
                                                   const MatrixXd& on_path) {
  const algebra::Spectrum spectrum = algebra::spectrum(on_path);
  const Index weak = (spectrum.values.array() < known_share).count();
  if (weak == 0) return {};
  const MatrixXd U = spectrum.vectors.leftCols(weak);
  const MatrixXd I = MatrixXd::Identity(claimed.rows(), claimed.cols());
  const MatrixXd left = U.transpose() * (I - on_path) * U;
  const algebra::Spectrum ratio = algebra::generalized_spectrum(U.transpose() * (I - claimed) * U, left);
  const VectorXd variances = variances_left(W, on_path);
  std::vector<SpuriousDirection> found;
  for (Index k = 0; k < weak && ratio.values[k] < known_share; ++k) {
    const VectorXd u = (U * ratio.vectors.col(k)).normalized();
    SpuriousDirection direction;
    direction.along = u;
    direction.claimed = u.dot(claimed * u);
    direction.removed = u.dot(on_path * u);
    // What is left unknown, projected: its covariance with uᵀ W⁻¹ e, over that one's deviation.
    const VectorXd f = W * ((I - on_path) * u) / std::sqrt(u.dot((I - on_path) * u));
    direction.parts = parts_of(f, variances_before(W), variances);
    found.push_back(std::move(direction));
  }
  sort(found);
  return found;
}

}  // namespace binnacle::observe
