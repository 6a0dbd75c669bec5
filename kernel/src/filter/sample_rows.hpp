// SPDX-License-Identifier: Apache-2.0
// The rows of the sample at work: linearize() fills them, judge() may thin them out, correct() applies them.
#pragma once

#include <cstdint>
#include <vector>

#include "filter/plan.hpp"

namespace binnacle::filter {

struct SampleRows {
  explicit SampleRows(const FilterPlan& plan);
  SampleRows(const SampleRows&) = delete;
  SampleRows& operator=(const SampleRows&) = delete;

  /// No rows of this measurement yet.
  void begin(const MeasurementPlan& measurement);
  MatrixView square(double* matrix) const { return {matrix, m, m, work.m_max}; }

  int m = 0;        // rows
  UpdateWork work;  // over the memory below; work.R is what the noise estimator makes of R_nominal
  double nis = 0;
  int left_out = 0;  // rows that a gate by row or key took out, and their keys and groups
  std::vector<double> R_nominal, delta;
  std::vector<std::int64_t> keys, left_out_keys;
  std::vector<int> groups, left_out_groups;

 private:
  std::vector<double> H_, R_, r_, G_, HPHt_, S_, L_, K_, U_, y_;
};

}  // namespace binnacle::filter
