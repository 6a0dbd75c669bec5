// SPDX-License-Identifier: Apache-2.0
// Which rows of one innovation disagree with all others.
#include "filter/exclusion.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "binnacle/view.hpp"
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
  const auto L = ConstMatrixView{work.L, m, m, work.m_max}.as();
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
  auto H = MatrixView{work.H, m, columns, work.m_max}.as();
  auto G = MatrixView{work.G, padded(n), m, padded(n)}.as();
  int kept = 0;
  for (int i = 0; i < m; ++i) {
    if (marked[i]) continue;
    H.row(kept) = H.row(i);
    G.col(kept) = G.col(i);
    for (double* matrix : {work.HPHt, R}) {
      auto square = MatrixView{matrix, m, m, work.m_max}.as();
      square.row(kept) = square.row(i);
      square.col(kept) = square.col(i);
    }
    work.r[kept] = work.r[i];
    keys[kept] = keys[i];
    groups[kept] = groups[i];
    ++kept;
  }
  return kept;
}

}  // namespace binnacle::filter
