// SPDX-License-Identifier: Apache-2.0
#include "filter/sample_rows.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

namespace binnacle::filter {

SampleRows::SampleRows(const FilterPlan& plan) {
  const auto ld = as_size(padded(plan.n)), rows = as_size(plan.max_rows);
  H_.resize(rows * as_size(plan.max_columns));
  for (auto* square : {&R_, &HPHt_, &S_, &L_, &R_nominal}) square->resize(rows * rows);
  for (auto* column : {&r_, &y_}) column->resize(rows);
  for (auto* tall : {&G_, &K_, &U_}) tall->resize(ld * std::max<std::size_t>(rows, 3));
  delta.resize(ld);
  for (auto* list : {&keys, &left_out_keys}) list->resize(rows);
  for (auto* list : {&groups, &left_out_groups}) list->resize(rows);
  static_cast<UpdateWork&>(*this) = {0,         plan.max_rows, H_.data(), R_.data(), r_.data(), G_.data(), HPHt_.data(),
                                     S_.data(), L_.data(),     K_.data(), U_.data(), y_.data()};
}

void SampleRows::begin(const MeasurementPlan& measurement) {
  m_max = measurement.max_rows;
  m = 0;
  left_out = 0;
  nis = 0;
  std::fill_n(H, as_size(m_max) * measurement.columns.size(), 0.0);
  std::fill_n(R_nominal.data(), m_max * m_max, 0.0);
}

void SampleRows::leave_out(const unsigned char* marked, int columns, int n) {
  auto rows_of_H = MatrixView{H, m, columns, m_max}.as();
  auto columns_of_G = MatrixView{G, padded(n), m, padded(n)}.as();
  int kept = 0;
  for (int i = 0; i < m; ++i) {
    if (marked[i]) continue;
    rows_of_H.row(kept) = rows_of_H.row(i);
    columns_of_G.col(kept) = columns_of_G.col(i);
    for (double* matrix : {HPHt, R_nominal.data()}) {
      auto both = square(matrix).as();
      both.row(kept) = both.row(i);
      both.col(kept) = both.col(i);
    }
    r[kept] = r[i];
    keys[as_size(kept)] = keys[as_size(i)];
    groups[as_size(kept)] = groups[as_size(i)];
    ++kept;
  }
  m = kept;
}

OutlierTest::OutlierTest(int max_rows)
    : inverse_(max_rows, max_rows),
      z_(max_rows),
      part_(max_rows, max_rows),
      part_z_(max_rows),
      members_(as_size(max_rows)),
      is_tested_(as_size(max_rows)),
      worst_(as_size(max_rows)) {}

void OutlierTest::invert(const UpdateWork& work) {
  const int m = work.m;
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

const unsigned char* OutlierTest::find(GateUnit unit, const std::vector<double>& limit, const SampleRows& rows) {
  invert(rows);
  std::fill_n(is_tested_.begin(), rows.m, 0);
  double largest = 1.0;
  for (int row = 0; row < rows.m; ++row) {
    if (is_tested_[as_size(row)]) continue;
    int count = 0;
    for (int other = row; other < rows.m; ++other)
      if (other == row || (unit == GateUnit::key && rows.keys[as_size(other)] == rows.keys[as_size(row)])) {
        members_[as_size(count++)] = other;
        is_tested_[as_size(other)] = 1;
      }
    const double beyond = statistic(count) / limit[as_size(count)];
    if (!(beyond > largest)) continue;
    largest = beyond;
    std::fill_n(worst_.begin(), rows.m, 0);
    for (int k = 0; k < count; ++k) worst_[as_size(members_[as_size(k)])] = 1;
  }
  return largest > 1.0 ? worst_.data() : nullptr;
}

}  // namespace binnacle::filter
