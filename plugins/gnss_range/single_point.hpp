// SPDX-License-Identifier: Apache-2.0
// Single-point solutions: position, velocity and clock of each epoch by itself, by iterated least squares.
#pragma once

#include <array>

#include "binnacle/source.hpp"
#include "gnss/corrections.hpp"
#include "gnss/range_noise.hpp"
#include "satellite_limit.hpp"
#include "solution_fields.hpp"

namespace binnacle::gnss_range {

struct SinglePointState;
struct SinglePointFix;

class SinglePoint final : public Transform {
 public:
  static ComponentSpec spec();
  explicit SinglePoint(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  using Sightings = std::array<gnss::Sighting, gnss::most_rows>;

  bool solve(const gnss::Corrections::Epoch& epoch, SinglePointFix& fix) const;
  int sight(const gnss::Corrections::Epoch& epoch, bool knows_place, const SinglePointFix& fix,
            Sightings& sightings) const;
  bool step(const Sightings& sightings, int count, bool knows_place, SinglePointFix& fix, double& moved) const;
  enum class Verdict { agree, excluded, disagree };
  Verdict exclude_worst(const Sightings& sightings, int count, SinglePointFix& fix) const;
  void solve_velocity(const Sightings& sightings, int count, SinglePointFix& fix) const;
  void emit(Time t, const SinglePointFix& fix, Emitter& emitter) const;

  gnss::Corrections corrections_;
  SatelliteLimit limit_;
  gnss::RangeNoise range_noise_, rate_noise_;
  double exclude_beyond_, max_gdop_, unknown_speed_, unknown_drift_;

  /// Of each of the two channels.
  struct Solution : PlaceFields {
    OutputChannel channel;
    OutputFields<2> clock;  // bias, drift
    OutputFields<2> count;  // used, excluded
    OutputField gdop;
    OutputFields<3> position_sd, velocity_sd;  // of ned only
  };
  Solution declare(const char* name, bool is_geodetic);
  void write(Time t, const SinglePointFix& fix, const Solution& to, SampleWriter& out) const;

  Input ephemeris_, klobuchar_;
  Solution ecef_, ned_;
  Memory<SinglePointState> state_;
};

}  // namespace binnacle::gnss_range
