// SPDX-License-Identifier: Apache-2.0
#include "periodogram.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

namespace binnacle::ship_motion {

namespace {

using std::numbers::pi;

}  // namespace

Welch::Welch(Eigen::Index length, double interval) : interval_(interval), window_(length) {
  for (Eigen::Index n = 0; n < length; ++n)
    window_[n] = 0.5 - 0.5 * std::cos(2 * pi * static_cast<double>(n) / static_cast<double>(length));
  // ∫ over −π/T … π/T of |X|² is 2π Σx²w²/T; twice, since one-sided.
  scale_ = interval / (pi * window_.squaredNorm());
  // E|X|² = Σ over lags of both signs of what the window leaves in pairs that far apart, times their covariance.
  pairs_.resize(length);
  for (Eigen::Index lag = 0; lag < length; ++lag)
    pairs_[lag] = (lag == 0 ? 1 : 2) * window_.head(length - lag).dot(window_.tail(length - lag));
}

double Welch::bin() const { return 2 * pi / (static_cast<double>(length()) * interval_); }

Spectrum Welch::of(const Eigen::VectorXd& series) const {
  const Eigen::Index bins = length() / 2 - 1;
  Spectrum spectrum;
  spectrum.omega = Eigen::VectorXd::LinSpaced(bins, 1, static_cast<double>(bins)) * bin();
  spectrum.width = Eigen::VectorXd::Constant(bins, bin());
  spectrum.density = Eigen::VectorXd::Zero(bins);
  Eigen::FFT<double> fft;
  std::vector<double> segment(static_cast<std::size_t>(length()));
  std::vector<std::complex<double>> transform;
  int segments = 0;
  for (Eigen::Index first = 0; first + length() <= series.size(); first += length() / 2, ++segments) {
    Eigen::Map<Eigen::VectorXd>(segment.data(), length()) = series.segment(first, length()).cwiseProduct(window_);
    fft.fwd(transform, segment);
    for (Eigen::Index k = 0; k < bins; ++k)
      spectrum.density[k] += scale_ * std::norm(transform[static_cast<std::size_t>(k + 1)]);
  }
  spectrum.density /= segments;
  return spectrum;
}

Eigen::VectorXd Welch::expected(const Eigen::VectorXd& autocovariance) const {
  Eigen::FFT<double> fft;
  std::vector<double> terms(static_cast<std::size_t>(length()));
  Eigen::Map<Eigen::VectorXd>(terms.data(), length()) = pairs_.cwiseProduct(autocovariance);
  std::vector<std::complex<double>> transform;
  fft.fwd(transform, terms);
  Eigen::VectorXd density(length() / 2 - 1);
  for (Eigen::Index k = 0; k < density.size(); ++k)
    density[k] = scale_ * transform[static_cast<std::size_t>(k + 1)].real();
  return density;
}

}  // namespace binnacle::ship_motion
