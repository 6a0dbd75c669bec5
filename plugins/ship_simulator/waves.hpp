// SPDX-License-Identifier: Apache-2.0
// How a ship moves in waves: sums of tones, given one by one or standing for a spectrum.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_simulator {

/// amplitude · sin(omega t + phase).
struct Tone {
  static constexpr double random_phase = std::numeric_limits<double>::quiet_NaN();

  double amplitude;  // rad or m
  double omega;      // rad/s
  double phase;      // rad; random_phase: drawn once a run
};

/// roll, pitch, yaw [rad]; surge, sway, heave [m]: along the mean heading, to the right of it, down.
enum Freedom : std::size_t { roll, pitch, yaw, surge, sway, heave };
inline constexpr std::size_t freedoms = 6;
inline constexpr std::array<const char*, freedoms> freedom_name = {"roll", "pitch", "yaw", "surge", "sway", "heave"};

/// The tones of a spectrum:   θ̈ + 2ζω θ̇ + ω² θ = w,  w white of density q = 4ζω³σ² (paper 004), has the one-sided density
///     S(ν) = (q/π) / ((ω² − ν²)² + (2ζων)²),   ∫₀^∞ S dν = σ².
/// It is cut into `count` bands of equal variance; in each stands one tone of amplitude σ√(2/count), at the frequency that
/// halves the variance of the band, with a random phase. The frequencies have no common period. What lies above the last
/// tone, where the spectrum's acceleration has no finite variance, is left out.
std::vector<Tone> tones_of_spectrum(double omega, double zeta, double sigma, int count);

/// The parameter of one degree of freedom, in `unit`, and how it is read.
std::vector<ParameterSpec> freedom_members(const std::string& unit);
std::vector<Tone> read_freedom(const Parameters& parameters, const std::string& pointer);

}  // namespace binnacle::ship_simulator
