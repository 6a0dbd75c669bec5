// SPDX-License-Identifier: Apache-2.0
// Standard deviations of a fix.
#include "reported_sigma.hpp"
#include "binnacle/eigen.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::gnss_fix {

std::vector<ParameterSpec> ReportedSigma::parameters(const std::string& unit) {
  const double most = unit == "m" ? 1e3 : 1e2;
  return {
      parameter::vector("sigma", unit, 3)
          .above(0)
          .plausible(1e-4, most)
          .about("standard deviation north, east, down, for axes for which the channel reports none; then required"),
      parameter::number("scale", "1").defaults("1").above(0).about("factor on the reported standard deviations"),
      parameter::vector("floor", unit, 3)
          .defaults("0")
          .at_least(0)
          .plausible(1e-4, most)
          .about("lower bound of the reported and scaled standard deviations: north, east, down"),
  };
}

std::vector<FieldSpec> ReportedSigma::fields(const std::string& prefix, const std::string& unit) {
  const auto of_axis = [&](const char* suffix, const char* axis) {
    return field::level(prefix + suffix, unit).optional().about(std::string("reported standard deviation, ") + axis);
  };
  return {of_axis("_n", "north"), of_axis("_e", "east"), of_axis("_d", "down")};
}

ReportedSigma::ReportedSigma(const Binding& binding, const std::string& prefix, const std::array<const char*, 3>& flaws)
    : scale_(binding.parameters().number("scale")) {
  const Parameters& parameters = binding.parameters();
  const auto floor = parameters.vector("floor");
  const Fields<3> reported = binding.fields(prefix + "_n", prefix + "_e", prefix + "_d");
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_reported = reported[axis].is_bound();
    if (!is_reported && !parameters.has("sigma"))
      throw ComponentError("the channel reports no standard deviation for every axis: give 'sigma'", "/sigma");
    axes_.push_back({reported[axis], is_reported ? 0.0 : parameters.vector("sigma")[axis], floor[axis],
                     flaws[static_cast<std::size_t>(axis)]});
  }
}

Result ReportedSigma::write_variances(const SampleView& sample, const MatrixView& R) const {
  for (int i = 0; i < 3; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    double sigma = axis.sigma;
    if (axis.reported.is_bound()) {
      const double reported = sample[axis.reported];
      if (!(std::isfinite(reported) && reported > 0.0)) return Result::invalid(axis.flaw);
      sigma = std::max(scale_ * reported, axis.floor);
    }
    R(i, i) = sigma * sigma;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_fix
