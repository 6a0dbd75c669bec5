// SPDX-License-Identifier: Apache-2.0
// What the atmosphere adds to a pseudorange.
#pragma once

namespace binnacle::gnss {

/// Broadcast coefficients: α_n [s / semicircle^n], β_n [s / semicircle^n].
struct Klobuchar {
  double alpha[4] = {};
  double beta[4] = {};
};

/// Delay on L1 [m]. lat, lon, azimuth, elevation [rad]; time_of_day: of GPS time [s]. IS-GPS-200 20.3.3.5.2.5 and
/// figure 20-4.
double klobuchar_delay(const Klobuchar& model, double lat, double lon, double azimuth, double elevation,
                       double time_of_day);

/// Delay along the line of sight and how it changes with height.
struct TroposphereDelay {
  double delay = 0;     // m
  double d_height = 0;  // m/m
};

/// Saastamoinen's zenith delay in the standard atmosphere with 70 % relative humidity, over sin(elevation).
/// J. Saastamoinen, "Contributions to the theory of atmospheric refraction", Bulletin Géodésique 107 (1973) 13-34; the
/// atmosphere of RTKLIB ver. 2.4.2 manual, E.5 (1). Heights are taken between −500 m and 30 km.
TroposphereDelay saastamoinen_delay(double lat, double height, double elevation);

}  // namespace binnacle::gnss
