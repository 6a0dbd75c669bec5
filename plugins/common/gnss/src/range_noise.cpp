// SPDX-License-Identifier: Apache-2.0
// How far a pseudorange or a range rate is trusted: by its row, its elevation, its C/N0.
#include "gnss/range_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binnacle::gnss {

namespace {

double squared(double x) { return x * x; }

}  // namespace

std::vector<ParameterSpec> RangeNoise::parameters(Of of, const char* default_sigma) {
  using namespace parameter;
  const char* const unit = of == Of::pseudorange ? "m" : "m/s";
  constexpr double least = 1e-4, most = 1e3;
  std::vector<ParameterSpec> specs{
      number("sigma", unit)
          .at_least(0)
          .plausible(least, most)
          .defaults(default_sigma)
          .about("constant part of the standard deviation; the variance is sigma^2 + (sigma_elevation / sin el)^2 + …"),
      number("sigma_elevation", unit)
          .at_least(0)
          .plausible(least, most)
          .defaults("0")
          .about("part of the standard deviation that grows with 1 / sin(elevation)"),
      number("sigma_cn0", unit)
          .at_least(0)
          .plausible(least, most)
          .defaults("0")
          .about("part of the standard deviation that grows as C/N0 falls: variance sigma_cn0^2 10^((cn0_reference - "
                 "C/N0) / 10)"),
      number("cn0_reference", "1")
          .at_least(0)
          .at_most(70)
          .defaults("45")
          .about("C/N0 at which that part is sigma_cn0, dB-Hz"),
      object("cn0_weight", {number("s1", "1").defaults("50").about("C/N0 above which the factor is 1, dB-Hz"),
                            number("s0", "1").defaults("10").about("C/N0 at which the factor is A, dB-Hz"),
                            number("a", "1").above(0).defaults("30").about("curvature of the factor over C/N0, dB-Hz"),
                            number("A", "1").above(0).defaults("30").about("factor at s0")})
          .about("factor on sigma^2 and (sigma_elevation / sin el)^2 that depends on C/N0, as in goGPS")};
  if (of == Of::pseudorange) {
    specs.push_back(number("sigma_ionosphere", "1")
                        .at_least(0)
                        .defaults("0")
                        .about("standard deviation of the ionosphere correction, relative to the correction; about "
                               "half remains after Klobuchar's model"));
    specs.push_back(
        number("sigma_accuracy", "1").at_least(0).defaults("0").about("factor on the broadcast accuracy (URA, SISA)"));
  }
  return specs;
}

RangeNoise::RangeNoise(const Parameters& parameters, Of of)
    : of_(of),
      sigma_(parameters.number("sigma")),
      by_elevation_(parameters.number("sigma_elevation")),
      by_cn0_(parameters.number("sigma_cn0")),
      cn0_reference_(parameters.number("cn0_reference")) {
  if (sigma_ == 0 && by_elevation_ == 0 && by_cn0_ == 0)
    throw ComponentError("sigma, sigma_elevation and sigma_cn0 are all zero: a measurement has some noise", "/sigma");
  if (parameters.has("cn0_weight")) {
    const Parameters weight = parameters.object("cn0_weight");
    weight_ = Weight{weight.number("s0"), weight.number("s1"), weight.number("a"), weight.number("A")};
    if (!(weight_->s0 < weight_->s1))
      throw ComponentError("s0, where the factor is A, lies below s1, where it is 1", "/cn0_weight/s0");
    if (sigma_ == 0 && by_elevation_ == 0)
      throw ComponentError("it is a factor on sigma and sigma_elevation, which are both zero", "/cn0_weight");
  }
  if (of != Of::pseudorange) return;
  ionosphere_ = parameters.number("sigma_ionosphere");
  accuracy_ = parameters.number("sigma_accuracy");
}

/// 1 at s1 and above, A at s0; below s0 as at s0, where the straight line would fall through zero.
double RangeNoise::Weight::at(double cn0) const {
  if (cn0 >= s1) return 1;
  const double s = std::max(cn0, s0);
  const double steep = std::pow(10.0, (s1 - s0) / a);
  return std::pow(10.0, (s1 - s) / a) * ((A / steep - 1) * (s1 - s) / (s1 - s0) + 1);
}

double RangeNoise::variance(const Sighting& s) const {
  const double given = of_ == Of::pseudorange ? s.range_variance : s.rate_variance;
  if (!std::isnan(given)) return given;
  if (needs_cn0() && !(s.cn0 > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double sine = std::max(std::sin(s.direction.elevation), least_sine);
  double own = squared(sigma_) + squared(by_elevation_ / sine);
  if (weight_) own *= weight_->at(s.cn0);
  if (by_cn0_ > 0) own += squared(by_cn0_) * std::pow(10.0, (cn0_reference_ - s.cn0) / 10);
  return own + squared(ionosphere_ * s.ionosphere) + (accuracy_ > 0 ? squared(accuracy_ * s.accuracy) : 0.0);
}

}  // namespace binnacle::gnss
