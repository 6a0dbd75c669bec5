// SPDX-License-Identifier: Apache-2.0
// The rows of the sample at work, and which of them disagree with all others: the gate by row or by key.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "filter/plan.hpp"

namespace binnacle::filter {

/// linearize() fills them, judge() may thin them out, correct() applies them. R is what the noise estimator makes of
/// R_nominal.
struct SampleRows : UpdateWork {
  explicit SampleRows(const FilterPlan& plan);
  SampleRows(const SampleRows&) = delete;
  SampleRows& operator=(const SampleRows&) = delete;

  /// No rows of this measurement yet.
  void begin(const MeasurementPlan& measurement);
  /// Takes the marked ones out of everything but R, S and what follows from it.
  void leave_out(const unsigned char* marked, int columns, int n);
  MatrixView square(double* matrix) const { return {matrix, m, m, m_max}; }

  double nis = 0;
  int left_out = 0;  // rows that a gate by row or key took out, and their keys and groups
  std::vector<double> R_nominal, delta;
  std::vector<std::int64_t> keys, left_out_keys;
  std::vector<int> groups, left_out_groups;

 private:
  std::vector<double> H_, R_, r_, G_, HPHt_, S_, L_, K_, U_, y_;
};

/// Baarda's data snooping on an innovation (Teunissen, Quality control in integrated navigation systems, 1990). With
/// z = S⁻¹ r, leaving out the rows I lowers the NIS by
///     T_I = z_Iᵀ [(S⁻¹)_II]⁻¹ z_I ,   χ² of |I| dof for a right sample.
/// It holds I against what all other rows and the prediction say together, so an error that all rows share and that the
/// filter leaves open (a receiver clock's) counts against none of them. Sized once: find() does not allocate.
class OutlierTest {
 public:
  explicit OutlierTest(int max_rows);

  /// Marks the rows of the unit whose T_I is largest beyond limit[|I|]: a mask over the rows; null when there is none.
  /// Needs the factor L of S and y = L⁻¹ r.
  const unsigned char* find(GateUnit unit, const std::vector<double>& limit, const SampleRows& rows);

 private:
  void invert(const UpdateWork& work);
  double statistic(int count);

  Eigen::MatrixXd inverse_;   // S⁻¹
  Eigen::VectorXd z_;         // S⁻¹ r
  Eigen::MatrixXd part_;      // (S⁻¹)_II
  Eigen::VectorXd part_z_;    // z_I
  std::vector<int> members_;  // I
  std::vector<unsigned char> is_tested_, worst_;
};

}  // namespace binnacle::filter
