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

/// How a zenith delay becomes one along the line of sight.
/// niell: the New Mapping Functions, hydrostatic and wet, by latitude, height and season; for elevations from 3 deg on.
/// cosecant: 1/sin(elevation), a flat earth.
enum class Mapping { niell, cosecant };

/// Saastamoinen's zenith delays in the standard atmosphere with 70 % relative humidity, mapped to the line of sight.
/// J. Saastamoinen, "Contributions to the theory of atmospheric refraction", Bulletin Géodésique 107 (1973) 13-34; the
/// atmosphere of RTKLIB ver. 2.4.2 manual, E.5 (1). Heights are taken between −500 m and 30 km. Angles [rad], height [m].
/// season: season_of() the day, 0: the mean over the year.
TroposphereDelay troposphere_delay(Mapping mapping, double lat, double height, double elevation, double season);

/// cos 2π (day − 28) / 365.25: 1 in midwinter of the north, by Niell's table. day: of the year, 1 is the first.
double season_of(double day_of_year);

/// Niell's factors. A. E. Niell, "Global mapping functions for the atmosphere delay at radio wavelengths", J. Geophys. Res.
/// 101 (B2) (1996) 3227-3246: equations (4) to (6), tables 3 and 4.
struct NiellFactors {
  double hydrostatic = 0, wet = 0;
  double d_hydrostatic = 0;  // of hydrostatic by height, 1/m
};
NiellFactors niell_factors(double lat, double height, double elevation, double season);

}  // namespace binnacle::gnss
