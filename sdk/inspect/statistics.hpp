// SPDX-License-Identifier: Apache-2.0
// Robust figures: medians, quantiles, and linear fits with standard errors.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace binnacle::inspect {

/// NaN of nothing; NaN elements are left out.
double quantile(std::vector<double> values, double p);
double median(std::vector<double> values);
/// 1.4826 × the median distance from the median: σ of a normal distribution.
double robust_sigma(const std::vector<double>& values);

/// Rows of single values far from both neighbours, which agree with each other, the farthest first: beyond `limit`, what the
/// tail of the record's own roughness reaches once in 10^4 records. None of fewer than 100 values.
std::vector<std::size_t> spikes(const std::vector<double>& values, double& limit);

/// Chance that Student's t of so many degrees of freedom is above t, t >= 0 (Abramowitz and Stegun, 26.7.3 and 26.7.4).
double student_tail(double t, std::size_t dof);

/// Tukey's biweight of a residual, whose limit is 4.685 σ: 1 at zero, 0 from there on.
double biweight(double residual, double sigma);

/// y = X β by iterated reweighting (Tukey's biweight).
struct LinearFit {
  Eigen::VectorXd beta, standard_error;
  double sigma = 0;      // of the residuals, robust
  double explained = 0;  // 1 - weighted residual sum over the weighted sum about the weighted mean
  std::size_t used = 0;  // rows; 0: too few
};
LinearFit robust_fit(const Eigen::MatrixXd& X, const Eigen::VectorXd& y);

}  // namespace binnacle::inspect
