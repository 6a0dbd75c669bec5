// SPDX-License-Identifier: Apache-2.0
#include "spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace binnacle::ship_motion {

namespace {

using std::numbers::pi;
constexpr double gravity = 9.80665;

}  // namespace

double Spectrum::moment(int n) const { return (omega.array().pow(n) * density.array() * width.array()).sum(); }

double Spectrum::peak() const {
  Eigen::Index at = 0;
  density.maxCoeff(&at);
  return omega[at];
}

Spectrum tabulated(const Eigen::VectorXd& omega, const Eigen::VectorXd& density) {
  const Eigen::Index n = omega.size();
  Spectrum spectrum{omega, density, Eigen::VectorXd::Zero(n)};
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    const double half = 0.5 * (omega[k + 1] - omega[k]);
    spectrum.width[k] += half;
    spectrum.width[k + 1] += half;
  }
  return spectrum;
}

Sea::Sea(double significant_height, double peak_period, double gamma)
    : height_(significant_height), peak_(2 * pi / peak_period), gamma_(gamma) {
  if (gamma == 1) return;
  const double step = 1e-3 * peak_;
  double area = 0;
  for (double omega = 0.5 * step; omega < 30 * peak_; omega += step) area += density(omega) * step;
  scale_ = height_ * height_ / 16 / area;
}

double Sea::density(double omega) const {
  if (omega <= 0) return 0;
  const double fourth = std::pow(peak_ / omega, 4);
  const double bretschneider = 5.0 / 16 * height_ * height_ * fourth / omega * std::exp(-1.25 * fourth);
  const double width = omega <= peak_ ? 0.07 : 0.09;
  const double distance = (omega - peak_) / (width * peak_);
  return scale_ * bretschneider * std::pow(gamma_, std::exp(-0.5 * distance * distance));
}

double Encounter::frequency(double omega) const {
  return std::abs(omega - omega * omega * speed * std::cos(heading) / gravity);
}

Response tabulated_response(const Eigen::VectorXd& omega, const Eigen::VectorXd& gain) {
  return [omega, gain](double at, double /*encounter*/) {
    const double* const end = omega.data() + omega.size();
    const auto above = std::upper_bound(omega.data(), end, at) - omega.data();
    if (above == omega.size() && at == end[-1]) return gain[above - 1];
    if (above == 0 || above == omega.size()) return 0.0;
    const double part = (at - omega[above - 1]) / (omega[above] - omega[above - 1]);
    return (1 - part) * gain[above - 1] + part * gain[above];
  };
}

Response resonant_response(double natural, double zeta, double gain, bool is_of_slope) {
  return [=](double omega, double encounter) {
    const double ratio = encounter / natural;
    const double amplification = 1 / std::abs(std::complex<double>(1 - ratio * ratio, 2 * zeta * ratio));
    return gain * amplification * (is_of_slope ? omega * omega / gravity : 1);
  };
}

namespace {

/// Adds to the bins the energy of waves that are met at frequencies from `low` to `high`; what is met beyond the bins is left out.
void deposit(double energy, double low, double high, Spectrum& bins) {
  const double width = bins.width[0];
  const auto first = static_cast<Eigen::Index>(low / width), last = static_cast<Eigen::Index>(high / width);
  for (Eigen::Index k = first; k <= std::min(last, bins.density.size() - 1); ++k) {
    const double left = static_cast<double>(k) * width;
    const double share = first == last ? 1 : (std::min(high, left + width) - std::max(low, left)) / (high - low);
    bins.density[k] += energy * share / width;
  }
}

/// Over 0 … `upper` rad/s of encounter.
Spectrum met_below(double upper, const Sea& sea, const Encounter& encounter, const Response& response,
                   double last_wave) {
  constexpr int bins = 400, waves = 20000;
  Spectrum spectrum;
  spectrum.width = Eigen::VectorXd::Constant(bins, upper / bins);
  spectrum.omega = Eigen::VectorXd::LinSpaced(bins, 0.5, bins - 0.5) * (upper / bins);
  spectrum.density = Eigen::VectorXd::Zero(bins);
  const double step = last_wave / waves;
  for (int i = 0; i < waves; ++i) {
    const double omega = (i + 0.5) * step;
    const double gain = response(omega, encounter.frequency(omega));
    const auto [low, high] =
        std::minmax({encounter.frequency(omega - 0.5 * step), encounter.frequency(omega + 0.5 * step)});
    deposit(gain * gain * sea.density(omega) * step, low, high, spectrum);
  }
  return spectrum;
}

}  // namespace

Spectrum motion_spectrum(const Sea& sea, const Encounter& encounter, const Response& response) {
  // 99.99 % of the energy of a wave spectrum lies below ten times its peak.
  const double last_wave = 10 * sea.peak();
  double upper = 0;
  for (int i = 0; i <= 400; ++i) upper = std::max(upper, encounter.frequency(last_wave * i / 400));
  // A response that falls off leaves little up there: the bins end where the motion does.
  const Spectrum coarse = met_below(upper, sea, encounter, response, last_wave);
  const double whole = coarse.moment(0);
  if (!(whole > 0)) return coarse;
  double below = 0;
  Eigen::Index end = 0;
  while (end < coarse.density.size() && below < 0.999 * whole) below += coarse.density[end] * coarse.width[end], ++end;
  return met_below(static_cast<double>(end) * coarse.width[0], sea, encounter, response, last_wave);
}

}  // namespace binnacle::ship_motion
