// SPDX-License-Identifier: Apache-2.0
// The constellation_simulator transform: from where a vehicle is to what its receiver measures.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::constellation_simulator {

/// Satellite i at an instant, seen from an antenna at r_e with velocity v_e (ECEF) and a clock of bias b and drift d:
///     ρ = |R(ωτ) r_i − r_e| + b − c δt_i + g_i + n        ρ̇ = range rate + d − c δṫ_i + n'
/// g_i is a Gauss–Markov process of each satellite, n and n' are white. The label is the receiver's: the satellite sends at
/// t − ρ/c − δt_i on the system's clock, as corrections.hpp takes it; a clock error moves the instant of both alike.
class ConstellationSimulator final : public Transform {
 public:
  static ComponentSpec spec();
  explicit ConstellationSimulator(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  struct Memory;
  struct Antenna;
  struct Row;
  struct Rows;
  struct Span {
    Time from, to;
    bool contains(Time t) const { return t >= from && t <= to; }
  };
  struct Cut {
    Span span;
    int satellites;
    bool keeps_lowest;
  };
  struct Fault {
    Span span;
    gnss::SatelliteKey satellite;
    double range, rate;  // m, m/s
  };
  struct Jump {
    Time at;
    double bias;  // m
  };

  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;
  void declare_channels();
  void declare_given(int rows);
  void read_events(const Parameters& parameters);
  void advance(Memory& memory, Time t) const;
  void emit_ephemerides(Time t, Emitter& emitter) const;
  const Cut* cut_at(Time t) const;
  bool is_visible(const Antenna& antenna, const Eigen::Vector3d& to_satellite) const;
  /// Adds a row for each satellite that is seen.
  void measure(const Antenna& antenna, Time t, Memory& memory, Rows& rows) const;
  static void apply(const Cut& cut, Rows& rows);
  void emit_given(Time t, const Memory& memory, const Rows& rows, Emitter& emitter) const;

  std::vector<gnss::Ephemeris> constellation_;
  Time every_;
  double min_sin_elevation_, min_sin_antenna_;
  bool has_antenna_mask_, has_rotation_;
  double bias_, tau_, noise_, rate_noise_;  // m, s, m, m/s
  double S_f_, S_g_, clock_bias_, clock_drift_;
  int systems_ = 0;    // of the channel `given`; 0: there is none
  double offset_ = 0;  // m
  std::vector<Cut> cuts_;
  std::vector<Fault> faults_;
  std::vector<Jump> jumps_;
  Fields<3> position_, velocity_, attitude_;
  OutputChannel observations_, ephemerides_, truth_, given_;
  OutputRowField satellite_, pseudorange_, range_rate_;
  OutputField clock_bias_field_, clock_drift_field_, seen_field_;
  std::vector<OutputField> offset_fields_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::constellation_simulator
