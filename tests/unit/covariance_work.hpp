// SPDX-License-Identifier: Apache-2.0
// Random transitions and updates for the arithmetic on P, as tables of blocks and as dense matrices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

#include <Eigen/Dense>

#include "filter/covariance_form.hpp"

namespace covariance_tests {

using namespace binnacle;
using namespace binnacle::internal::filter;
using Eigen::MatrixXd;
using Eigen::VectorXd;

inline MatrixXd random_matrix(int rows, int columns, std::mt19937& engine) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(engine); });
}

inline MatrixXd random_covariance(int n, std::mt19937& engine) {
  const MatrixXd A = random_matrix(n, n, engine);
  const MatrixXd P = A * A.transpose() + MatrixXd::Identity(n, n);
  return 0.5 * (P + P.transpose());  // to the bit
}

/// P as the filter stores it: columns padded to whole strips.
struct Stored {
  explicit Stored(const MatrixXd& P)
      : n(static_cast<int>(P.rows())), data(static_cast<std::size_t>(padded(n) * n), 0.0) {
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) data[static_cast<std::size_t>(i + j * padded(n))] = P(i, j);
  }
  MatrixXd matrix() const {
    return Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>>(data.data(), n, n, Eigen::OuterStride<>(padded(n)));
  }
  bool is_symmetric_to_the_bit() const {
    const MatrixXd P = matrix();
    return (P.array() == P.transpose().array()).all();
  }
  bool padding_is_zero() const {
    for (int j = 0; j < n; ++j)
      for (int i = n; i < padded(n); ++i)
        if (data[static_cast<std::size_t>(i + j * padded(n))] != 0) return false;
    return true;
  }
  int n;
  std::vector<double> data;
};

/// A transition of random structure, sparse and dense.
struct RandomTransition {
  /// coupled_first: groups are the rows before it, and no others; −1: any.
  RandomTransition(int n, std::mt19937& engine, int coupled_first = -1)
      : Phi(MatrixXd::Identity(n, n)), Q(MatrixXd::Zero(n, n)) {
    plan.n = n;
    for (int row = 0; row < n;) {
      const int rows = std::min<int>(1 + static_cast<int>(engine() % 3), n - row);
      const int drawn = static_cast<int>(engine() % 3);
      const int kind = coupled_first < 0 ? drawn : row < coupled_first ? 2 : drawn % 2;
      if (kind == 1) {  // diagonal only
        std::vector<double> block;
        for (int r = 0; r < rows; ++r) {
          block.push_back(random_matrix(1, 1, engine)(0, 0));
          Phi(row + r, row + r) = block.back();
          plan.diagonals.push_back({row + r, static_cast<int>(blocks.size()), r});
        }
        blocks.push_back(block);
      } else if (kind == 2) {  // a group over a random set of columns
        RowGroup group;
        group.first_row = row;
        group.rows = rows;
        group.is_in_one_run = engine() % 2;
        Phi.middleRows(row, rows).setZero();
        std::vector<double> block;
        for (int column = 0; column < n; ++column) {
          if (engine() % 2) continue;
          group.columns.push_back({column, static_cast<int>(blocks.size()), static_cast<int>(block.size())});
          for (int r = 0; r < rows; ++r) {
            block.push_back(random_matrix(1, 1, engine)(0, 0));
            Phi(row + r, column) = block.back();
          }
          if (group.is_in_one_run) continue;
          blocks.push_back(block);
          block.clear();
        }
        group.is_in_one_run &= !group.columns.empty();
        if (group.is_in_one_run) blocks.push_back(block);
        plan.groups.push_back(group);
      }
      const MatrixXd q = random_covariance(rows, engine);
      Q.block(row, row, rows, rows) = q;
      noise.push_back({q.data(), q.data() + q.size()});
      plan.noise.push_back({row, row, places(rows), places(rows, rows), static_cast<int>(noise.size()) - 1});
      if (row > 0 && engine() % 2) {                                   // a cross block below the diagonal
        const MatrixXd cross = 0.01 * random_matrix(rows, 1, engine);  // Q stays positive definite
        Q.block(row, 0, rows, 1) += cross;
        Q.block(0, row, 1, rows) += cross.transpose();
        noise.push_back({cross.data(), cross.data() + cross.size()});
        plan.noise.push_back({row, 0, places(rows), places(1), static_cast<int>(noise.size()) - 1});
      }
      row += rows;
    }
    finish(plan);
  }
  MatrixXd Phi, Q;
  TransitionPlan plan;
  std::vector<std::vector<double>> blocks, noise;  // column-major
};

inline TransitionPlan identity(int n) {
  TransitionPlan plan;
  plan.n = n;
  finish(plan);
  return plan;
}

struct Update {
  Update(const MatrixXd& H, const MatrixXd& R, const VectorXd& residual, int n, int m_max)
      : m(static_cast<int>(H.rows())) {
    const auto size = [](int a, int b) { return static_cast<std::size_t>(a) * static_cast<std::size_t>(b); };
    for (auto* square : {&R_, &HPHt, &S, &L}) square->assign(size(m_max, m_max), 0);
    for (auto* tall : {&G, &K, &U}) tall->assign(size(padded(n), std::max(m_max, 3)), 0);
    r.assign(static_cast<std::size_t>(m_max), 0);
    y = r;
    for (int c = 0; c < n; ++c) {
      if (H.col(c).isZero()) continue;
      columns.push_back(c);
      for (int i = 0; i < m_max; ++i) H_.push_back(i < m ? H(i, c) : 0);
    }
    for (int i = 0; i < m; ++i) {
      r[static_cast<std::size_t>(i)] = residual(i);
      for (int j = 0; j < m; ++j) R_[static_cast<std::size_t>(i + j * m_max)] = R(i, j);
    }
    work = {m,           m_max,    H_.data(), R_.data(), r.data(), G.data(),
            HPHt.data(), S.data(), L.data(),  K.data(),  U.data(), y.data()};
  }
  int m;
  std::vector<int> columns;
  std::vector<double> H_, R_, r, G, HPHt, S, L, K, U, y;
  UpdateWork work;
};

}  // namespace covariance_tests
