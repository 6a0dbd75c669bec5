// SPDX-License-Identifier: Apache-2.0
#include "filter/noise_check.hpp"

#include <cmath>
#include <cstdio>

namespace binnacle::filter {

namespace {

constexpr double rounding = 1e-9;  // of an element, in the geometric mean of its variances

bool is_symmetric(MatrixView R, int i, int j) {
  const double difference = R(i, j) - R(j, i);
  return difference * difference <= rounding * rounding * R(i, i) * R(j, j);
}

std::string element(int i, int j, double value) {
  char text[64];
  std::snprintf(text, sizeof text, "R(%d, %d) = %.6g", i, j, value);
  return text;
}

}  // namespace

bool is_noise(MatrixView R) {
  double sum = 0;  // NaN if anything is not finite
  bool is_sound = true;
  for (int j = 0; j < R.cols; ++j) {
    is_sound = is_sound && R(j, j) >= 0;
    sum += R(j, j) * 0.0;
    for (int i = 0; i < j; ++i) {
      sum += R(i, j) * 0.0;
      is_sound = is_sound && (R(i, j) == R(j, i) || is_symmetric(R, i, j));
    }
  }
  return is_sound && sum == 0.0;
}

std::string flaw_of_noise(MatrixView R) {
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i < R.rows; ++i)
      if (!std::isfinite(R(i, j))) return element(i, j, R(i, j)) + ", which is not finite";
  for (int i = 0; i < R.rows; ++i)
    if (R(i, i) < 0) return element(i, i, R(i, i)) + ", which is no variance";
  for (int j = 0; j < R.cols; ++j)
    for (int i = 0; i < j; ++i)
      if (R(i, j) != R(j, i) && !is_symmetric(R, i, j))
        return element(i, j, R(i, j)) + " but " + element(j, i, R(j, i)) + ", which is not symmetric";
  return "";
}

}  // namespace binnacle::filter
