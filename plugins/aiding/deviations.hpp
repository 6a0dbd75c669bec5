// SPDX-License-Identifier: Apache-2.0
// The standard deviations of a reading: what the channel reports with it, else the parameter.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "binnacle/binding.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/result.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/view.hpp"

namespace binnacle::aiding {

/// Up to three components: per component NAME the optional field NAME_sd; where the channel has none, `sigma`.
class Deviations {
 public:
  /// `size` 1: a number, else a vector.
  static ParameterSpec parameter(int size, const std::string& unit, double least, double most) {
    ParameterSpec spec = size == 1 ? parameter::number("sigma", unit) : parameter::vector("sigma", unit, size);
    return std::move(spec)
        .above(0)
        .plausible(least, most)
        .about("standard deviation of the white noise, used if the channel reports none; then required");
  }
  static FieldSpec field(const std::string& name, const std::string& unit) {
    return field::level(name + "_sd", unit).optional().about("standard deviation of " + name);
  }

  /// `names`: of the components, of which null ones are not measured; one name: `sigma` is a number.
  template <std::size_t N>
  Deviations(const Binding& binding, const std::array<const char*, N>& names) {
    const Parameters& parameters = binding.parameters();
    const bool has_sigma = parameters.has("sigma");
    for (std::size_t i = 0; i < N; ++i) {
      if (!names[i]) continue;
      Axis& axis = axes_[static_cast<std::size_t>(rows_++)];
      const std::string reported = std::string(names[i]) + "_sd";
      axis.reported = binding.field(reported);
      if (has_sigma) {
        axis.sigma = N == 1 ? parameters.number("sigma") : parameters.vector("sigma")[static_cast<Eigen::Index>(i)];
      } else if (!axis.reported.is_bound()) {
        throw ComponentError("missing key 'sigma': the channel carries no '" + reported + "'", "");
      }
    }
  }

  /// R's diagonal, a row for each component that is measured; `invalid` where the channel reports what is no deviation.
  Result write_variances(const SampleView& sample, const MatrixView& R) const {
    for (int row = 0; row < rows_; ++row) {
      const Axis& axis = axes_[static_cast<std::size_t>(row)];
      const double sigma = axis.reported.is_bound() ? sample[axis.reported] : axis.sigma;
      if (!(sigma > 0) || !std::isfinite(sigma * sigma))
        return Result::invalid("a reported standard deviation is 0, negative or not finite");
      R(row, row) = sigma * sigma;
    }
    return Result::ok();
  }

 private:
  struct Axis {
    Field reported;
    double sigma = 0;
  };
  std::array<Axis, 3> axes_;
  int rows_ = 0;
};

}  // namespace binnacle::aiding
