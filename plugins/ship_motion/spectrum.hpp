// SPDX-License-Identifier: Apache-2.0
// Spectra: of a sea, and of what a ship that meets it does.
#pragma once

#include <functional>

#include <Eigen/Core>

namespace binnacle::ship_motion {

/// One-sided density over rad/s: its integral is the variance. Frequencies rise.
struct Spectrum {
  Eigen::VectorXd omega;    // rad/s
  Eigen::VectorXd density;  // unit² s
  Eigen::VectorXd width;    // of omega that each stands for [rad/s]

  /// ∫ ωⁿ S dω.
  double moment(int n) const;
  /// Where the density is greatest [rad/s].
  double peak() const;
};

/// Each value stands for the trapezoids beside it.
Spectrum tabulated(const Eigen::VectorXd& omega, const Eigen::VectorXd& density);

/// JONSWAP (Hasselmann et al. 1973); `gamma` 1 is Bretschneider's. Scaled so that the significant height is 4 √m₀ for any gamma.
class Sea {
 public:
  Sea(double significant_height, double peak_period, double gamma = 1);  // m, s, 1

  double peak() const { return peak_; }  // rad/s
  double density(double omega) const;    // m² s

 private:
  double height_, peak_, gamma_, scale_ = 1;
};

/// How a ship meets waves on deep water. `heading` 180°: against them, 0: with them.
struct Encounter {
  double speed = 0;    // m/s
  double heading = 0;  // rad, between the ship's way and the waves'

  /// ω_e = |ω − ω² U cos μ / g|.
  double frequency(double omega) const;
};

/// Amplitude of the motion for a wave of amplitude 1 m, by the wave's own frequency and that at which the ship meets it.
using Response = std::function<double(double omega, double encounter)>;

/// The response by wave frequency, linear between the points of a table, zero outside.
Response tabulated_response(const Eigen::VectorXd& omega, const Eigen::VectorXd& gain);
/// A damped mass on a spring, by frequency of encounter: gain / |1 − r² + 2iζr|, r = ω_e/ω_n; of a wave of height 1 m, or of slope 1
/// (k a with k = ω²/g) where `is_of_slope`.
Response resonant_response(double natural, double zeta, double gain, bool is_of_slope);

/// What the ship does, over the frequency of encounter: S(ω_e) dω_e = |H|² S(ω) dω, summed where several waves are met at one
/// frequency (following seas).
Spectrum motion_spectrum(const Sea& sea, const Encounter& encounter, const Response& response);

}  // namespace binnacle::ship_motion
