// SPDX-License-Identifier: Apache-2.0
// How a ship moves in waves.
#include "waves.hpp"

#include <cmath>
#include <numbers>

namespace binnacle::ship_simulator {

std::vector<Tone> tones_of_spectrum(double omega, double zeta, double sigma, int count) {
  // With ν = ω tan u the density becomes smooth on a finite interval:
  //   S dν ∝ (1 + tan²u) / ((1 − tan²u)² + 4ζ² tan²u) du = (1 / (cos²2u + ζ² sin²2u)) cos²u du
  constexpr int steps = 20000;
  const double du = 0.5 * std::numbers::pi / steps;
  const auto density = [zeta](double u) {
    const double c = std::cos(u), c2 = std::cos(2 * u), s2 = zeta * std::sin(2 * u);
    return c * c / (c2 * c2 + s2 * s2);
  };
  std::vector<double> below(steps + 1, 0.0);  // variance below u, by the midpoint rule
  for (std::size_t i = 0; i < steps; ++i) below[i + 1] = below[i] + density((static_cast<double>(i) + 0.5) * du);

  std::vector<Tone> tones;
  std::size_t i = 0;
  for (int band = 0; band < count; ++band) {
    const double wanted = below.back() * (band + 0.5) / count;
    while (below[i + 1] < wanted) ++i;
    const double u = (static_cast<double>(i) + (wanted - below[i]) / (below[i + 1] - below[i])) * du;
    tones.push_back({sigma * std::sqrt(2.0 / count), omega * std::tan(u), Tone::random_phase});
  }
  return tones;
}

std::vector<ParameterSpec> freedom_members(const std::string& unit) {
  using namespace parameter;
  std::vector<ParameterSpec> tone = {
      number("amplitude", unit).required().about("amplitude, half of the peak-to-peak motion"),
      number("frequency", "Hz").above(0).at_most(100).required().about("frequency"),
      number("phase", "rad").about("phase of the sine at the start; default: drawn once per run"),
  };
  std::vector<ParameterSpec> spectrum = {
      number("omega", "rad/s").above(0).at_most(100).required().about("natural frequency"),
      number("zeta", "1").above(0).at_most(2).required().about("damping"),
      number("sigma", unit).at_least(0).required().about("standard deviation"),
      integer("tones").at_least(1).at_most(1000).defaults("40").about("number of tones that represent the spectrum"),
  };
  return {
      list("tones", object("tone", std::move(tone))).defaults("[]").about("list of tones"),
      object("spectrum", std::move(spectrum)).about("tones that represent a second-order spectrum"),
  };
}

std::vector<Tone> read_freedom(const Parameters& parameters, const std::string& pointer) {
  std::vector<Tone> tones;
  if (parameters.has("spectrum")) {
    const Parameters s = parameters.object("spectrum");
    tones =
        tones_of_spectrum(s.number("omega"), s.number("zeta"), s.number("sigma"), static_cast<int>(s.integer("tones")));
    if (!parameters.list("tones").empty())
      throw ComponentError("either 'tones' or 'spectrum', not both", pointer + "/tones");
  }
  for (const ParameterValue& element : parameters.list("tones")) {
    const Parameters tone(element);
    tones.push_back({tone.number("amplitude"), 2.0 * std::numbers::pi * tone.number("frequency"),
                     tone.has("phase") ? tone.number("phase") : Tone::random_phase});
  }
  return tones;
}

}  // namespace binnacle::ship_simulator
