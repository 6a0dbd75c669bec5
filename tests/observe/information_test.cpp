// SPDX-License-Identifier: Apache-2.0
// The information of a window against the conditional covariance of one dense Gaussian, in long double.
#include "catch.hpp"

#include <random>
#include <vector>

#include <Eigen/Dense>

#include "observe/information.hpp"

namespace information_test {

using namespace binnacle;
using Eigen::MatrixXd;

namespace {

using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// A filter of one block, all of whose components are coupled.
FilterInfo dense_filter(int n) {
  FilterInfo filter;
  filter.dof = n;
  filter.blocks.resize(1);
  for (int i = 0; i < n; ++i) filter.blocks[0].active.push_back(i);
  filter.transition = {{0, 0, Structure::dense}};
  filter.measurements.resize(2);
  return filter;
}

/// The initial error, process and measurement noise as one Gaussian: errors and residuals are linear in it.
class Dense {
 public:
  explicit Dense(const MatrixXd& P)
      : n_(P.rows()), initial_(Wide::Identity(n_, n_)), now_(initial_), covariance_(P.cast<long double>()) {}
  void step(const MatrixXd& Phi, const MatrixXd& Q) {
    now_ = (Phi.cast<long double>() * now_).eval();
    now_.rightCols(add(Q)).setIdentity();
  }
  void turn(const MatrixXd& T) { now_ = (T.cast<long double>() * now_).eval(); }
  void update(const MatrixXd& H, const MatrixXd& R) {
    const Wide of_error = H.cast<long double>() * now_;
    const Eigen::Index m = add(R), before = seen_.rows();
    seen_.conservativeResizeLike(Wide::Zero(before + m, now_.cols()));
    seen_.block(before, 0, m, of_error.cols()) = of_error;
    seen_.block(before, of_error.cols(), m, m).setIdentity();
  }
  /// Of the error at the start, given all residuals.
  Wide left() const {
    const Wide of_both = initial_ * covariance_ * seen_.transpose(), of_seen = seen_ * covariance_ * seen_.transpose();
    return initial_ * covariance_ * initial_.transpose() - of_both * of_seen.ldlt().solve(Wide(of_both.transpose()));
  }

 private:
  Eigen::Index add(const MatrixXd& noise) {
    const Eigen::Index m = noise.rows(), size = covariance_.rows();
    covariance_.conservativeResizeLike(Wide::Zero(size + m, size + m));
    covariance_.bottomRightCorner(m, m) = noise.cast<long double>();
    for (Wide* A : {&initial_, &now_, &seen_}) A->conservativeResizeLike(Wide::Zero(A->rows(), size + m));
    return m;
  }
  Eigen::Index n_;
  Wide initial_, now_, covariance_, seen_;
};

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  MatrixXd matrix(int rows, int columns) {
    MatrixXd A(rows, columns);
    for (double& a : A.reshaped()) a = std::normal_distribution<double>()(engine);
    return A;
  }
  MatrixXd covariance(int n, int rank) {
    const MatrixXd A = matrix(n, rank);
    return A * A.transpose();
  }
  std::mt19937 engine;
};

ConstMatrixView view(const MatrixXd& A) {
  const auto rows = static_cast<int>(A.rows());
  return {A.data(), rows, static_cast<int>(A.cols()), rows};
}

void check(const observe::Information& information, const Dense& dense, const MatrixXd& P) {
  const MatrixXd& W = information.root();
  const MatrixXd I = MatrixXd::Identity(W.cols(), W.cols());
  const Wide left = (W * (I - information.removed()) * W.transpose()).cast<long double>();
  CHECK(static_cast<double>((left - dense.left()).norm()) < 1e-10 * P.norm());
  CHECK((W * W.transpose() - P).norm() < 1e-12 * P.norm());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(information.removed());
  CHECK(solver.eigenvalues().minCoeff() > -1e-10);
  CHECK(solver.eigenvalues().maxCoeff() < 1);
  CHECK((information.removed_by(0) + information.removed_by(1) - information.removed()).norm() < 1e-12);
}

}  // namespace

TEST_CASE("what the samples of a window leave of the covariance at its start is that of one dense Gaussian") {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const int n = 2 + static_cast<int>(seed % 5), rank = seed % 3 == 0 ? n - 1 : n;
    INFO("seed " << seed << ", " << n << " components, P of rank " << rank);
    const FilterInfo filter = dense_filter(n);
    const smooth::TransitionPattern pattern(filter);
    const MatrixXd scales = random.matrix(n, 1).array().exp().pow(2).matrix().asDiagonal();  // units apart
    const MatrixXd P = scales * random.covariance(n, rank) * scales;
    observe::Information information(pattern, P, 2, false), without_noise(pattern, P, 2, true);
    Dense dense(P), noiseless(P);
    REQUIRE(information.root().cols() == rank);
    std::vector<double> phi(pattern.size());
    for (int k = 0; k < 6; ++k) {
      const MatrixXd Phi = MatrixXd::Identity(n, n) + 0.3 * scales * random.matrix(n, n) * scales.inverse();
      const MatrixXd Q = 0.1 * scales * random.covariance(n, 1 + k % n) * scales;
      pattern.gather(view(Phi), phi.data());
      information.step(phi.data(), view(Q));
      without_noise.step(phi.data(), view(Q));
      dense.step(Phi, Q);
      noiseless.step(Phi, MatrixXd::Zero(n, n));
      if (k == 2) {
        const std::vector<double> variances(static_cast<std::size_t>(n), 0.2);
        information.inflate(variances.data());
        without_noise.inflate(variances.data());
        dense.step(MatrixXd::Identity(n, n), 0.2 * MatrixXd::Identity(n, n));
      }
      const int m = 1 + k % 2;
      const MatrixXd H = random.matrix(m, n) * scales.inverse(), R = random.covariance(m, m + 1);
      REQUIRE(information.update(k % 2, view(H), view(R)));
      REQUIRE(without_noise.update(k % 2, view(H), view(R)));
      dense.update(H, R);
      noiseless.update(H, R);
      const MatrixXd T = MatrixXd::Identity(n, n) + 0.1 * scales * random.matrix(n, n) * scales.inverse();
      if (k % 3 == 0) {
        information.reset(view(T));
        without_noise.reset(view(T));
        dense.turn(T);
        noiseless.turn(T);
      }
    }
    check(information, dense, P);
    check(without_noise, noiseless, P);
    CHECK(information.removed().trace() < without_noise.removed().trace());
  }
}

TEST_CASE("a sample whose innovation has no variance is left out, and changes nothing") {
  const FilterInfo filter = dense_filter(2);
  const smooth::TransitionPattern pattern(filter);
  const MatrixXd P = MatrixXd::Identity(2, 2), H = MatrixXd::Zero(1, 2), R = MatrixXd::Zero(1, 1);
  observe::Information information(pattern, P, 2, false);
  CHECK_FALSE(information.update(0, view(H), view(R)));
  CHECK(information.removed().isZero(0));
  CHECK(information.covariance() == P);
}

TEST_CASE("a history keeps whole what is short, and ever fewer of what is long") {
  observe::History history;
  for (int k = 0; k < 512; ++k) history.add(k, MatrixXd::Constant(1, 1, k));
  REQUIRE(history.entries().size() == 512);
  CHECK(history.entries()[17].t == 17);
  history.add(511, MatrixXd::Constant(1, 1, -1));
  CHECK(history.entries().back().removed(0, 0) == -1);
  for (int k = 512; k < 5000; ++k) history.add(k, MatrixXd::Constant(1, 1, k));
  CHECK(history.entries().size() > 200);
  CHECK(history.entries().size() <= 512);
  for (std::size_t i = 1; i < history.entries().size(); ++i)
    CHECK(history.entries()[i].t - history.entries()[i - 1].t <= 5000 / 256);
}

}  // namespace information_test
