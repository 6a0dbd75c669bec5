// SPDX-License-Identifier: Apache-2.0
// The source: a coning motion as increments of an inertial sensor, and truth.
#pragma once

#include <cstdint>

#include "binnacle/source.hpp"
#include "coning_motion.hpp"
#include "simulation/clock.hpp"
#include "simulation/fields.hpp"

namespace binnacle::coning_simulator {

class ConingSimulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit ConingSimulator(const Binding& binding);

  SourceStatus next(const MemoryView& bytes, SourceOutput& out) const override;

  enum Channel { imu, truth };

 private:
  struct Memory {
    std::int64_t next_sample = 1, next_truth = 0;
  };

  explicit ConingSimulator(const Parameters& parameters);
  void declare_channels();
  long double nanoseconds_at(std::int64_t sample) const { return 1e9L * interval_ * static_cast<long double>(sample); }
  Time end_of(std::int64_t sample) const;
  Time due(std::int64_t sample) const;
  double cycle_at(long double seconds) const;
  void emit_imu(std::int64_t sample, SampleWriter& out) const;
  void emit_truth(Time t, SampleWriter& out) const;

  Cone cone_;
  ConingMotion motion_;
  bool has_place_, is_single_;
  long double interval_;  // s, of one sample
  Time duration_;
  simulation::Clock truth_clock_;
  OutputChannel imu_channel_, truth_channel_;
  simulation::ImuFields imu_;
  OutputFields<3> position_, velocity_, attitude_;  // of truth; the first two only with a place
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::coning_simulator
