// SPDX-License-Identifier: Apache-2.0
// The source: a coning motion as increments of an inertial sensor, and truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "binnacle/source.hpp"
#include "coning_motion.hpp"
#include "simulation/clock.hpp"

namespace binnacle::coning_simulator {

class ConingSimulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit ConingSimulator(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override;
  void start(std::uint64_t seed, std::byte* memory) const override;
  SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const override;

  enum Channel { imu, truth };

 private:
  struct Memory;

  explicit ConingSimulator(const Parameters& parameters);
  Time end_of(std::int64_t sample) const;
  double cycle_at(long double seconds) const;
  void emit_imu(std::int64_t sample, SampleSlot& slot) const;
  void emit_truth(Time t, SampleSlot& slot) const;

  Cone cone_;
  ConingMotion motion_;
  bool has_place_, is_single_;
  long double interval_;  // s, of one sample
  Time duration_;
  simulation::Clock truth_clock_;
  std::vector<ChannelDeclaration> channels_;
};

}  // namespace binnacle::coning_simulator
