// SPDX-License-Identifier: Apache-2.0
// What keeps an estimate of R within reason, and turns variances of rows into R.
#include "bounds.hpp"

#include <cmath>
#include <utility>

namespace binnacle::adaptive_noise {

std::vector<ParameterSpec> bounds_parameters(std::string floor) {
  using namespace parameter;
  return {
      number("floor", "1")
          .at_least(0)
          .defaults(std::move(floor))
          .about("smallest standard deviation, as a factor on the nominal one"),
      number("ceiling", "1")
          .above(0)
          .about("largest standard deviation, as a factor on the nominal one; default: no bound"),
  };
}

Bounds read_bounds(const Parameters& parameters) {
  const Bounds bounds{parameters.number("floor"), parameters.has("ceiling") ? parameters.number("ceiling") : 1e150};
  if (bounds.ceiling < bounds.floor) throw ComponentError("the ceiling is below the floor", "/ceiling");
  return bounds;
}

ParameterSpec learn_below_parameter() {
  return parameter::number("learn_below", "1")
      .above(0)
      .defaults("1")
      .about("rows are not used for the estimate while HP-H' exceeds this factor times their nominal R");
}

void set_variances(const double* variances, MatrixView R) noexcept {
  for (int j = 0; j < R.cols; ++j)
    for (int i = j + 1; i < R.rows; ++i) {
      const double nominal = R(i, i) * R(j, j);
      R(i, j) = R(j, i) = nominal > 0.0 ? R(i, j) * std::sqrt(variances[i] * variances[j] / nominal) : 0.0;
    }
  for (int i = 0; i < R.rows; ++i) R(i, i) = variances[i];
}

}  // namespace binnacle::adaptive_noise
