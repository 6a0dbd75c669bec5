// SPDX-License-Identifier: Apache-2.0
// The source: a target seen from a vessel that changes its course.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "binnacle/parameters.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"
#include "random/philox.hpp"
#include "simulation/clock.hpp"

namespace binnacle::target_simulator {

using Eigen::Vector2d;

/// A straight piece of the observer's way, at constant velocity.
struct Leg {
  double from;  // s
  Vector2d p;   // m, where it begins
  Vector2d v;   // m/s
};

/// In a plane, axes north and east:
///     target    p' = v ,  v' = w ,  p(0) = p₀ + N(0, diag σ_p²) ,  v(0) = v₀ + N(0, diag σ_v²)
///     observer  legs of constant velocity
///     azimuth   = atan2(d_e, d_n) + N(0, σ²) ,  d = target − observer
/// w is white noise of density q². p₀ and v₀ are what a filter starts from, so truth = estimate ⊞ δ, δ ~ N(0, P₀).
class TargetSimulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit TargetSimulator(const Binding& binding);

  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override;

 private:
  struct Memory;
  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;
  void declare_channels();
  void advance(Memory& memory) const;
  Vector2d observer_at(double t) const;

  Time duration_;
  simulation::Clock clock_;
  double sigma_, q_;
  Vector2d p0_, v0_, p_sigma_, v_sigma_;
  std::vector<Leg> legs_;
  OutputChannel bearing_channel_, truth_channel_;
  OutputField azimuth_;
  OutputFields<2> observer_, position_, velocity_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::target_simulator
