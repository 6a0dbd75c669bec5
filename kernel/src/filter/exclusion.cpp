// SPDX-License-Identifier: Apache-2.0
// Which rows of one innovation disagree with all others.
#include "filter/exclusion.hpp"

#include <algorithm>
#include <cstddef>

#include <Eigen/Cholesky>

#include "filter/layout.hpp"

namespace binnacle::filter {

OutlierTest::OutlierTest(int max_rows)
    : inverse_(max_rows, max_rows),
      z_(max_rows),
      part_(max_rows, max_rows),
      part_z_(max_rows),
      members_(as_size(max_rows)),
      is_tested_(as_size(max_rows)),
      worst_(as_size(max_rows)) {}

void OutlierTest::invert(int m, const UpdateWork& work) {
  const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> L(work.L, m, m, Eigen::OuterStride<>(work.m_max));
  auto inverse = inverse_.topLeftCorner(m, m);
  inverse.setIdentity();
  L.triangularView<Eigen::Lower>().solveInPlace(inverse);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(inverse);
  auto z = z_.head(m);
  z = Eigen::Map<const Eigen::VectorXd>(work.y, m);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(z);
}

double OutlierTest::statistic(int count) {
  if (count == 1) {
    const int row = members_[0];
    return z_[row] * z_[row] / inverse_(row, row);
  }
  auto A = part_.topLeftCorner(count, count);
  auto z = part_z_.head(count);
  for (int j = 0; j < count; ++j) {
    z[j] = z_[members_[as_size(j)]];
    for (int i = 0; i < count; ++i) A(i, j) = inverse_(members_[as_size(i)], members_[as_size(j)]);
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(A);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(in_place);
  factor.matrixL().solveInPlace(z);
  return z.squaredNorm();
}

const unsigned char* OutlierTest::find(GateUnit unit, const std::vector<double>& limit, int m, const std::int64_t* keys,
                                       const UpdateWork& work) {
  invert(m, work);
  std::fill_n(is_tested_.data(), m, static_cast<unsigned char>(0));
  double largest = 1.0;
  bool is_found = false;
  for (int row = 0; row < m; ++row) {
    if (is_tested_[as_size(row)]) continue;
    int count = 0;
    for (int other = row; other < m; ++other)
      if (other == row || (unit == GateUnit::key && keys[other] == keys[row])) members_[as_size(count++)] = other;
    for (int k = 0; k < count; ++k) is_tested_[as_size(members_[as_size(k)])] = 1;
    const double beyond = statistic(count) / limit[as_size(count)];
    if (!(beyond > largest)) continue;
    largest = beyond;
    is_found = true;
    std::fill_n(worst_.data(), m, static_cast<unsigned char>(0));
    for (int k = 0; k < count; ++k) worst_[as_size(members_[as_size(k)])] = 1;
  }
  return is_found ? worst_.data() : nullptr;
}

int leave_out(const unsigned char* marked, int m, int columns, int n, double* R, std::int64_t* keys, int* groups,
              const UpdateWork& work) {
  const auto keep_rows = [&](double* matrix, int stride, int cols) {
    for (int j = 0; j < cols; ++j) {
      double* const column = matrix + static_cast<std::ptrdiff_t>(j) * stride;
      int kept = 0;
      for (int i = 0; i < m; ++i)
        if (!marked[i]) column[kept++] = column[i];
    }
  };
  const auto keep_columns = [&](double* matrix, int stride, int rows) {
    int kept = 0;
    for (int j = 0; j < m; ++j) {
      if (marked[j]) continue;
      std::copy_n(matrix + static_cast<std::ptrdiff_t>(j) * stride, rows,
                  matrix + static_cast<std::ptrdiff_t>(kept) * stride);
      ++kept;
    }
  };
  keep_rows(work.H, work.m_max, columns);
  keep_rows(work.r, work.m_max, 1);
  for (double* square : {work.HPHt, R}) {
    keep_rows(square, work.m_max, m);
    keep_columns(square, work.m_max, m);
  }
  keep_columns(work.G, padded(n), padded(n));
  int kept = 0;
  for (int i = 0; i < m; ++i) {
    if (marked[i]) continue;
    keys[kept] = keys[i];
    groups[kept] = groups[i];
    ++kept;
  }
  return kept;
}

}  // namespace binnacle::filter
