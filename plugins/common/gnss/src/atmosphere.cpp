// SPDX-License-Identifier: Apache-2.0
// What the atmosphere adds to a pseudorange.
#include "gnss/atmosphere.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "gnss/gps_time.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::gnss {

namespace {

double polynomial(const double* c, double x) { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }

/// Niell (1996) tables 3 and 4: a, b, c at 15, 30, 45, 60 and 75 deg.
using Coefficients = std::array<double, 3>;
using Table = std::array<Coefficients, 5>;
constexpr Table dry_mean{{{1.2769934e-3, 2.9153695e-3, 62.610505e-3},
                          {1.2683230e-3, 2.9152299e-3, 62.837393e-3},
                          {1.2465397e-3, 2.9288445e-3, 63.721774e-3},
                          {1.2196049e-3, 2.9022565e-3, 63.824265e-3},
                          {1.2045996e-3, 2.9024912e-3, 64.258455e-3}}};
constexpr Table dry_amplitude{{{0, 0, 0},
                               {1.2709626e-5, 2.1414979e-5, 9.0128400e-5},
                               {2.6523662e-5, 3.0160779e-5, 4.3497037e-5},
                               {3.4000452e-5, 7.2562722e-5, 84.795348e-5},
                               {4.1202191e-5, 11.723375e-5, 170.37206e-5}}};
constexpr Table wet_mean{{{5.8021897e-4, 1.4275268e-3, 4.3472961e-2},
                          {5.6794847e-4, 1.5138625e-3, 4.6729510e-2},
                          {5.8118019e-4, 1.4572752e-3, 4.3908931e-2},
                          {5.9727542e-4, 1.5007428e-3, 4.4626982e-2},
                          {6.1641693e-4, 1.7599082e-3, 5.4736038e-2}}};
constexpr Coefficients by_height{2.53e-5, 5.49e-3, 1.14e-3};

/// Linear between the latitudes of the table, constant beyond them.
Coefficients at_latitude(const Table& table, double degrees) {
  const double place = std::clamp(degrees / 15 - 1, 0.0, 4.0);
  const auto below = std::min<std::size_t>(static_cast<std::size_t>(place), 3);
  const double share = place - static_cast<double>(below);
  Coefficients result{};
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = table[below][i] * (1 - share) + table[below + 1][i] * share;
  return result;
}

/// Marini's, normalized to 1 at the zenith: equation (4).
double continued_fraction(const Coefficients& c, double sine) {
  const auto fraction = [&](double s) { return s + c[0] / (s + c[1] / (s + c[2])); };
  return fraction(1) / fraction(sine);
}

}  // namespace

double klobuchar_delay(const Klobuchar& model, double lat, double lon, double azimuth, double elevation,
                       double time_of_day) {
  // Angles in semicircles, as the standard has them.
  const double E = elevation / M_PI;
  const double psi = 0.0137 / (E + 0.11) - 0.022;
  const double phi_i = std::clamp(lat / M_PI + psi * std::cos(azimuth), -0.416, 0.416);
  const double lambda_i = lon / M_PI + psi * std::sin(azimuth) / std::cos(phi_i * M_PI);
  const double phi_m = phi_i + 0.064 * std::cos((lambda_i - 1.617) * M_PI);
  double t = std::fmod(4.32e4 * lambda_i + time_of_day, seconds_per_day);
  if (t < 0) t += seconds_per_day;
  const double slant = 1 + 16 * std::pow(0.53 - E, 3);
  const double amplitude = std::max(0.0, polynomial(model.alpha, phi_m));
  const double period = std::max(72000.0, polynomial(model.beta, phi_m));
  const double x = 2 * M_PI * (t - 50400) / period;
  const double day = std::abs(x) < 1.57 ? amplitude * (1 - x * x / 2 + x * x * x * x / 24) : 0.0;
  return speed_of_light * slant * (5e-9 + day);
}

double season_of(double day_of_year) { return std::cos(2 * M_PI * (day_of_year - 28) / 365.25); }

NiellFactors niell_factors(double lat, double height, double elevation, double season) {
  const double degrees = std::abs(lat) * 180 / M_PI;
  // In the south the seasons are half a year later: cos(x + π).
  const double phase = lat < 0 ? -season : season;
  Coefficients dry = at_latitude(dry_mean, degrees);
  const Coefficients amplitude = at_latitude(dry_amplitude, degrees);
  for (std::size_t i = 0; i < dry.size(); ++i) dry[i] -= amplitude[i] * phase;
  const double sine = std::sin(elevation);
  const double per_height = (1 / sine - continued_fraction(by_height, sine)) / 1e3;
  return {continued_fraction(dry, sine) + per_height * height, continued_fraction(at_latitude(wet_mean, degrees), sine),
          per_height};
}

TroposphereDelay troposphere_delay(Mapping mapping, double lat, double height, double elevation, double season) {
  const double h = std::clamp(height, -500.0, 30000.0);
  const double base = 1 - 2.2557e-5 * h;
  const double pressure = 1013.25 * std::pow(base, 5.2568);
  const double d_pressure = pressure * 5.2568 * -2.2557e-5 / base;
  const double temperature = 15 - 6.5e-3 * h + 273.16;
  const double cooled = temperature - 38.45;
  const double vapour = 6.108 * 0.7 * std::exp((17.15 * temperature - 4684) / cooled);
  const double d_vapour = vapour * -6.5e-3 * (17.15 * cooled - (17.15 * temperature - 4684)) / (cooled * cooled);

  const double gravity = 1 - 0.00266 * std::cos(2 * lat) - 0.00028 * h / 1e3;
  const double dry = 0.0022768 * pressure / gravity;
  const double d_dry = 0.0022768 * d_pressure / gravity + dry * 0.00028 / 1e3 / gravity;
  const double factor = 0.002277 * (1255 / temperature + 0.05);
  const double wet = factor * vapour;
  const double d_wet = factor * d_vapour + 0.002277 * 1255 * 6.5e-3 / (temperature * temperature) * vapour;
  TroposphereDelay result;
  if (mapping == Mapping::cosecant) {
    const double slant = 1 / std::sin(elevation);
    result = {(dry + wet) * slant, (d_dry + d_wet) * slant};
  } else {
    const NiellFactors m = niell_factors(lat, h, elevation, season);
    result = {dry * m.hydrostatic + wet * m.wet, d_dry * m.hydrostatic + dry * m.d_hydrostatic + d_wet * m.wet};
  }
  if (h != height) result.d_height = 0;
  return result;
}

}  // namespace binnacle::gnss
