// SPDX-License-Identifier: Apache-2.0
#include "filter/sample_rows.hpp"

#include <algorithm>

namespace binnacle::filter {

SampleRows::SampleRows(const FilterPlan& plan) {
  const auto ld = as_size(padded(plan.n));
  const auto rows = as_size(plan.max_rows), columns = as_size(plan.max_columns);
  H_.assign(rows * columns, 0.0);
  for (auto* square : {&R_, &HPHt_, &S_, &L_, &R_nominal}) square->assign(rows * rows, 0.0);
  for (auto* column : {&r_, &y_}) column->assign(rows, 0.0);
  for (auto* tall : {&G_, &K_, &U_}) tall->assign(ld * std::max<std::size_t>(rows, 3), 0.0);
  delta.assign(ld, 0.0);
  for (auto* list : {&keys, &left_out_keys}) list->assign(rows, 0);
  for (auto* list : {&groups, &left_out_groups}) list->assign(rows, 0);
  work = UpdateWork{plan.max_rows, H_.data(), R_.data(), r_.data(), G_.data(), HPHt_.data(),
                    S_.data(),     L_.data(), K_.data(), U_.data(), y_.data()};
}

void SampleRows::begin(const MeasurementPlan& measurement) {
  work.m_max = measurement.max_rows;
  m = 0;
  left_out = 0;
  nis = 0;
  std::fill_n(work.H, as_size(work.m_max) * measurement.columns.columns.size(), 0.0);
  std::fill_n(R_nominal.data(), work.m_max * work.m_max, 0.0);
}

}  // namespace binnacle::filter
