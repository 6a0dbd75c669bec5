// SPDX-License-Identifier: Apache-2.0
// A sky for tests: broadcast messages of 24 satellites, and what a receiver under it measures. The measurement is made
// in inertial axes from the definition of a pseudorange, with none of the code that is under test but the orbits'.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Dense>

#include "../plugins/bind.hpp"
#include "gnss/channels.hpp"
#include "gnss/observation_rows.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::test {

/// Where a receiver is at a true time [s], ECEF.
using Track = std::function<Eigen::Vector3d(double)>;
/// How far its clock is ahead at a true time [s].
using ClockTrack = std::function<double(double)>;

struct Sky {
  std::vector<gnss::Ephemeris> ephemerides;

  /// Six planes of four; with every term of a broadcast message, different for each.
  Sky() {
    for (int k = 0; k < 24; ++k) {
      gnss::Ephemeris e;
      e.satellite = gnss::satellite_key(gnss::Constellation::gps, k + 1);
      e.toe = 7200;
      e.toc = 7200 + 16;
      e.semi_major_axis = 26560e3 + 500.0 * k;
      e.eccentricity = 0.0004 * (k + 1);
      e.i0 = 55 * M_PI / 180;
      e.omega0 = (k / 4) * M_PI / 3 + 0.1;
      e.perigee = 0.3 * k;
      e.m0 = (k % 4) * M_PI / 2 + (k / 4) * 0.6 - e.perigee;
      e.delta_n = 4.5e-9;
      e.omega_dot = -8e-9;
      e.i_dot = 2e-10;
      e.cuc = 1e-6, e.cus = 8e-6, e.crc = 250, e.crs = -60, e.cic = 1e-7, e.cis = -8e-8;
      e.af0 = 1e-5 * (k - 12);
      e.af1 = 1e-11 * (k % 5);
      e.af2 = 1e-18;
      e.group_delay = -1e-8 * (k % 3);
      e.accuracy = 2;
      e.issue = k;
      ephemerides.push_back(e);
    }
  }

  static Eigen::Vector3d inertial(const Eigen::Vector3d& ecef, double t) {
    return Eigen::AngleAxisd(gnss::omega_e * t, Eigen::Vector3d::UnitZ()) * ecef;
  }

  static gnss::SatelliteState state(const gnss::Ephemeris& e, double t) { return gnss::satellite_state(e, 0, -t); }

  /// c (receiver's clock at reception − satellite's clock at transmission), group delay included.
  double pseudorange(const gnss::Ephemeris& e, double t, const Track& track, const ClockTrack& clock) const {
    const Eigen::Vector3d receiver = inertial(track(t), t);
    double travel = 0.075;
    for (int i = 0; i < 10; ++i)
      travel = (inertial(state(e, t - travel).position, t - travel) - receiver).norm() / gnss::speed_of_light;
    return gnss::speed_of_light * (travel + clock(t) - (state(e, t - travel).clock - e.group_delay));
  }

  std::vector<double> ephemeris_rows() const {
    std::vector<double> rows;
    for (const auto& e : ephemerides) {
      rows.resize(rows.size() + gnss::ephemeris_field_count);
      gnss::write_ephemeris(e, rows.data() + rows.size() - gnss::ephemeris_field_count);
    }
    return rows;
  }

  /// Rows of an observation channel for an epoch whose label, by the receiver's clock, is `label` [s]: everything above
  /// the horizon. Range rates by differences of the pseudorange over two seconds of the true time.
  std::vector<double> observe(double label, const Track& track, const ClockTrack& clock) const {
    double t = label;
    for (int i = 0; i < 5; ++i) t = label - clock(t);
    std::vector<double> rows;
    for (const auto& e : ephemerides) {
      const Eigen::Vector3d up = track(t).normalized();
      if ((state(e, t).position - track(t)).normalized().dot(up) < 0.05) continue;
      const auto at = [&](double s) { return pseudorange(e, s, track, clock); };
      const double coarse = (at(t + 1) - at(t - 1)) / 2, fine = at(t + 0.5) - at(t - 0.5);
      rows.insert(rows.end(), {static_cast<double>(e.satellite), at(t), (4 * fine - coarse) / 3, 40});
    }
    return rows;
  }
};

inline SampleView rows_view(const std::vector<double>& rows, int fields, Time t) {
  SampleView view;
  view.t = t;
  view.rows = static_cast<int>(rows.size()) / fields;
  view.row_fields = rows.data();
  view.available = true;
  return view;
}

/// Of a row as models read it: observation_fields() and given_fields().
inline int wide_fields() { return gnss::observation::field_count + static_cast<int>(gnss::given_fields().size()); }
/// Rows of observation_fields() with NaN for all that a channel may give besides.
inline std::vector<double> widened(const std::vector<double>& rows) {
  std::vector<double> wide;
  for (std::size_t i = 0; i < rows.size(); i += gnss::observation::field_count) {
    wide.insert(wide.end(), rows.begin() + static_cast<std::ptrdiff_t>(i),
                rows.begin() + static_cast<std::ptrdiff_t>(i + gnss::observation::field_count));
    wide.resize(wide.size() + gnss::given_fields().size(), std::nan(""));
  }
  return wide;
}

/// On a channel that carries observation_fields() alone.
template <class Model>
auto bind_by_ephemeris(Setup setup) {
  for (const FieldSpec& field : gnss::given_fields()) setup.without.push_back(field.name);
  return bind<Model>(setup);
}

}  // namespace binnacle::test
