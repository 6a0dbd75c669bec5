// SPDX-License-Identifier: Apache-2.0
// From an epoch of observations to the satellites that are used and what each adds to its range: the same for
// measurement models and single-point solutions.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "gnss/channels.hpp"
#include "gnss/observation_rows.hpp"
#include "gnss/signal_path.hpp"

namespace binnacle::gnss {

inline constexpr int most_rows = 2 * most_satellites_per_constellation;
inline constexpr double least_sine = 0.017;  // of elevation, where a mapping 1/sin is cut off: 1 deg

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
  std::int64_t system = 0;  // of the satellite
  double pseudorange = 0;   // m, as measured
  double range_rate = 0;    // m/s, as measured; NaN where there is none
  SignalPath path;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the satellite, axes of transmission, m/s
  double delay = 0;         // m, what is to be added to range + receiver clock: −c dt_sat + group delay + atmosphere
  double d_delay_down = 0;  // m/m, ∂delay by the antenna's motion down
  double rate_delay = 0;    // m/s: −c × drift of the satellite's clock
  Direction direction;
  double ionosphere = 0;                                  // m, part of delay
  double accuracy = 0;                                    // m, as the message gives it
  double cn0 = std::numeric_limits<double>::quiet_NaN();  // dB-Hz; NaN where there is none
  // m², m²/s², as the row gives them; NaN where it does not.
  double range_variance = std::numeric_limits<double>::quiet_NaN();
  double rate_variance = std::numeric_limits<double>::quiet_NaN();
};

/// What is corrected, and which satellites are used.
class Corrections {
 public:
  static std::vector<ParameterSpec> parameters();
  explicit Corrections(const Binding& binding);

  struct Epoch {
    Time t = no_time;
    const SampleView* observations = nullptr;
    const SampleView* ephemerides = nullptr;  // null: satellites are given
    const SampleView* klobuchar = nullptr;
  };
  /// What became of the rows of an epoch.
  struct Tally {
    int used = 0;
    int without_ephemeris = 0;
    int masked = 0;     // elevation, C/N0, excluded
    int unusable = 0;   // no pseudorange, no satellite
    int misplaced = 0;  // given without a position that a satellite can have, or without a clock where others have one
    int repeated = 0;   // given a second time
  };

  /// How the rows of every epoch are read; at first, the fields of observation_fields() alone.
  void read_rows_as(const ObservationRows& rows) { rows_ = rows; }

  bool wants_klobuchar() const noexcept { return klobuchar_; }
  bool has_rotation() const noexcept { return earth_rotation_; }

  /// Sightings in the order of the rows. knows_place: false while the place is so wrong that elevation and atmosphere
  /// mean nothing (a cold start); then neither is applied.
  Tally sight(const Epoch& epoch, const AntennaPlace& place, bool knows_place,
              std::array<Sighting, most_rows>& out) const;
  /// Leaves the `most` highest satellites, in their order; the number that is left.
  static int keep_highest(std::array<Sighting, most_rows>& sightings, int count, int most);

 private:
  /// Orbit and clock of a satellite at transmission, and what its message says of itself.
  struct Sender {
    SatelliteState state;
    double group_delay = 0, accuracy = 0;
  };
  void take(const Epoch& epoch, Tally& tally, const AntennaPlace& place, bool knows_place, int row,
            std::array<Sighting, most_rows>& out) const;
  Sender by_ephemeris(const Epoch& epoch, double pseudorange, const Ephemeris& ephemeris) const;
  bool by_row(const SampleView& observations, int row, Sender& sender) const;
  bool correct(const Epoch& epoch, const AntennaPlace& place, bool knows_place, const Sender& sender,
               Sighting& sighting) const;
  bool is_excluded(SatelliteKey key) const;

  ObservationRows rows_;
  std::vector<SatelliteKey> excluded_;
  double min_sin_elevation_;
  double min_cn0_;
  bool earth_rotation_, satellite_clock_, group_delay_, klobuchar_, saastamoinen_;
};

}  // namespace binnacle::gnss
