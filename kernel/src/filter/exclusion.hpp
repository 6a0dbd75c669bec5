// SPDX-License-Identifier: Apache-2.0
// Which rows of one innovation disagree with all others: the gate by row or by key.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "filter/covariance.hpp"

namespace binnacle::filter {

/// What a gate tests: a whole sample, its rows one by one, or the rows of one key (a satellite's) together.
enum class GateUnit : unsigned char { sample, row, key };

/// Baarda's data snooping on an innovation (Teunissen, Quality control in integrated navigation systems, 1990). With
/// z = S⁻¹ r, leaving out the rows I lowers the NIS by
///     T_I = z_Iᵀ [(S⁻¹)_II]⁻¹ z_I ,   χ² of |I| dof for a right sample.
/// It holds I against what all other rows and the prediction say together, so an error that all rows share and that the
/// filter leaves open (a receiver clock's) counts against none of them. Sized once: find() does not allocate.
class OutlierTest {
 public:
  explicit OutlierTest(int max_rows);

  /// Marks the rows of the unit whose T_I is largest beyond limit[|I|]: a mask over the m rows; null when there is none.
  /// Needs the factor L of S and y = L⁻¹ r.
  const unsigned char* find(GateUnit unit, const std::vector<double>& limit, int m, const std::int64_t* keys,
                            const UpdateWork& work);

 private:
  void invert(int m, const UpdateWork& work);
  double statistic(int count);

  Eigen::MatrixXd inverse_;   // S⁻¹
  Eigen::VectorXd z_;         // S⁻¹ r
  Eigen::MatrixXd part_;      // (S⁻¹)_II
  Eigen::VectorXd part_z_;    // z_I
  std::vector<int> members_;  // I
  std::vector<unsigned char> is_tested_, worst_;
};

/// Leaves the marked ones of m rows out of H, r, G, H P Hᵀ and of the m_max×m_max R; `keys` and `groups` alike. Returns how
/// many stay.
int leave_out(const unsigned char* marked, int m, int columns, int n, double* R, std::int64_t* keys, int* groups,
              const UpdateWork& work);

}  // namespace binnacle::filter
