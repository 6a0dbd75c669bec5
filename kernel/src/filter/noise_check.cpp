// SPDX-License-Identifier: Apache-2.0
#include "filter/noise_check.hpp"

#include <cmath>
#include <cstdio>

namespace binnacle::filter {

namespace {

constexpr double rounding = 1e-9;  // of an element, in the geometric mean of its variances

bool is_symmetric(ConstMatrixView R, int i, int j) {
  const double difference = R(i, j) - R(j, i);
  return difference == 0 || difference * difference <= rounding * rounding * R(i, i) * R(j, j);
}

std::string element(int i, int j, double value) {
  char text[64];
  std::snprintf(text, sizeof text, "R(%d, %d) = %.6g", i, j, value);
  return text;
}

}  // namespace

bool is_noise(ConstMatrixView R) {
  for (int j = 0; j < R.cols; ++j) {
    if (!(R(j, j) >= 0)) return false;
    for (int i = 0; i < j; ++i)
      if (!is_symmetric(R, i, j)) return false;
  }
  return is_finite(R);
}

std::string flaw_of_noise(ConstMatrixView R) {
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i < R.rows; ++i)
      if (!std::isfinite(R(i, j))) return element(i, j, R(i, j)) + ", which is not finite";
  for (int i = 0; i < R.rows; ++i)
    if (R(i, i) < 0) return element(i, i, R(i, i)) + ", which is no variance";
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i < j; ++i)
      if (!is_symmetric(R, i, j))
        return element(i, j, R(i, j)) + " but " + element(j, i, R(j, i)) + ", which is not symmetric";
  return "";
}

}  // namespace binnacle::filter
