// SPDX-License-Identifier: Apache-2.0
// A shaping filter fitted to a spectrum, and how well it fits.
#pragma once

#include "periodogram.hpp"
#include "shaping_filter.hpp"
#include "spectrum.hpp"

namespace binnacle::ship_motion {

struct ShapingFit {
  ShapingFilter filter;
  double given_significant;  // amplitude, 2 √m₀, of what was fitted to
  double model_significant;  // of the model over the same frequencies, as seen in the same way
  double given_peak;         // rad/s
  double model_peak;
  double resolution;  // rad/s: distance of the frequencies about the given peak
  double misfit;      // part of the area that lies elsewhere, ½ ∫|S − S_model| / ∫S

  bool is_good() const;
};

/// ω and ζ by least squares of the densities; σ is not fitted but the root of the variance, which a filter's covariance hangs on.
ShapingFit fit(int order, const Spectrum& given);
/// To Welch's spectrum of a series without mean: its expected value for the model is compared, so that neither window nor sampling
/// broadens the model.
ShapingFit fit(int order, const Eigen::VectorXd& series, const Welch& welch);

}  // namespace binnacle::ship_motion
