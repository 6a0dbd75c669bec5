// SPDX-License-Identifier: Apache-2.0
// Welch's estimate of the spectrum of a series, and what it is on average for a process of given autocovariance.
#pragma once

#include <Eigen/Core>

#include "spectrum.hpp"

namespace binnacle::ship_motion {

/// Averaged periodograms of overlapping halves under Hann's window (Welch, The use of fast Fourier transform for the estimation of
/// power spectra, IEEE Trans. Audio Electroacoust. 15(2), 1967). The mean is the caller's to remove.
class Welch {
 public:
  /// Segments of `length` samples, even and at least 8, `interval` seconds apart.
  Welch(Eigen::Index length, double interval);

  /// At 2πk/(length · interval), k = 1 … length/2 − 1. The series has at least `length` samples.
  Spectrum of(const Eigen::VectorXd& series) const;
  /// The expected value of the same: leakage of the window and aliasing included (the "debiased" spectrum of Sykulski et al.,
  /// Biometrika 106(2), 2019). `autocovariance` at 0 … length − 1 intervals.
  Eigen::VectorXd expected(const Eigen::VectorXd& autocovariance) const;

  Eigen::Index length() const { return window_.size(); }
  double interval() const { return interval_; }
  double bin() const;  // rad/s

 private:
  double interval_;
  Eigen::VectorXd window_;
  double scale_;  // of |X|² to a one-sided density
  Eigen::VectorXd pairs_;
};

}  // namespace binnacle::ship_motion
