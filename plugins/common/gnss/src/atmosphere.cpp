// SPDX-License-Identifier: Apache-2.0
// What the atmosphere adds to a pseudorange.
#include "gnss/atmosphere.hpp"

#include <algorithm>
#include <cmath>

#include "gnss/gps_time.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::gnss {

namespace {

double polynomial(const double* c, double x) { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }

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

TroposphereDelay saastamoinen_delay(double lat, double height, double elevation) {
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
  const double slant = 1 / std::sin(elevation);
  return {(dry + wet) * slant, h == height ? (d_dry + d_wet) * slant : 0.0};
}

}  // namespace binnacle::gnss
