// SPDX-License-Identifier: Apache-2.0
// From an epoch of observations to the satellites that are used and what each adds to its range: the same for
// measurement models and single-point solutions.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "gnss/channels.hpp"
#include "gnss/signal_path.hpp"

namespace binnacle::gnss {

inline constexpr int most_rows = 2 * most_satellites_per_constellation;

/// Where the antenna is thought to be.
struct AntennaPlace {
  Eigen::Vector3d ecef;  // m
  Eigen::Vector3d lla;   // rad, rad, m
  Eigen::Matrix3d C_en;
};
AntennaPlace place_from_ecef(const Eigen::Vector3d& ecef);
AntennaPlace place_from_lla(const Eigen::Vector3d& lla);

/// A satellite of an epoch, ready to be compared with what the state predicts.
struct Sighting {
  SatelliteKey satellite = 0;
  double pseudorange = 0;  // m, as measured
  double range_rate = 0;   // m/s, as measured; NaN where there is none
  SignalPath path;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the satellite, axes of transmission, m/s
  double delay = 0;         // m, what is to be added to range + receiver clock: −c dt_sat + group delay + atmosphere
  double d_delay_down = 0;  // m/m, ∂delay by the antenna's motion down
  double rate_delay = 0;    // m/s: −c × drift of the satellite's clock
  Direction direction;
  double ionosphere = 0;  // m, part of delay
  double accuracy = 0;    // m, as the message gives it
};

/// What is corrected, and which satellites are used.
class Corrections {
 public:
  static std::vector<ParameterSpec> parameters();
  explicit Corrections(const Binding& binding);

  struct Epoch {
    Time t = no_time;
    const SampleView* observations = nullptr;  // rows as observation::Field
    const SampleView* ephemerides = nullptr;
    const SampleView* klobuchar = nullptr;
  };
  /// What became of the rows of an epoch.
  struct Tally {
    int used = 0;
    int without_ephemeris = 0;
    int masked = 0;    // elevation, C/N0, excluded
    int unusable = 0;  // no pseudorange, no satellite
  };

  bool wants_klobuchar() const noexcept { return klobuchar_; }
  bool has_rotation() const noexcept { return earth_rotation_; }

  /// Sightings in the order of the rows. knows_place: false while the place is so wrong that elevation and atmosphere
  /// mean nothing (a cold start); then neither is applied.
  Tally sight(const Epoch& epoch, const AntennaPlace& place, bool knows_place,
              std::array<Sighting, most_rows>& out) const;
  /// Leaves the `most` highest satellites, in their order; the number that is left.
  static int keep_highest(std::array<Sighting, most_rows>& sightings, int count, int most);

 private:
  bool correct(const Epoch& epoch, const AntennaPlace& place, bool knows_place, Sighting& sighting,
               const Ephemeris& ephemeris) const;
  bool is_excluded(SatelliteKey key) const;

  std::vector<SatelliteKey> excluded_;
  double min_sin_elevation_;
  double min_cn0_;
  bool earth_rotation_, satellite_clock_, group_delay_, klobuchar_, saastamoinen_;
};

/// σ² = (σ₀² + (σ_e / sin el)²) + (f · ionosphere)² + (URA)².
class ElevationNoise {
 public:
  /// `with_ionosphere`: for pseudoranges.
  static std::vector<ParameterSpec> parameters(const char* unit, bool with_path_errors, const char* default_sigma);
  ElevationNoise(const Parameters& parameters, bool with_path_errors);
  double variance(const Sighting& sighting) const;

 private:
  double sigma_, by_elevation_;
  double ionosphere_ = 0, accuracy_ = 0;
};

}  // namespace binnacle::gnss
