// SPDX-License-Identifier: Apache-2.0
// Displacements along a path that is known: what measures them, simulated.
#pragma once

#include <Eigen/Core>

#include "binnacle/random.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::clone {

/// From one sample of the path to the first that comes at least `every` later, with z = A d + v as in RelativePosition,
/// v white with σ² = sigma² + (relative |d|)² per axis. The sensor is at p + C_nb l, l: `lever_arm`. The next displacement begins where the last one ended.
class Displacement final : public Transform {
 public:
  static ComponentSpec spec();
  explicit Displacement(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  struct Memory {
    Time t = no_time;    // of the begin
    double position[3];  // there: latitude, longitude, height, or x, y, z
    double attitude[4];  // quaternion body → navigation
    random::Philox random;
  };
  void initialise(std::uint64_t seed, const MemoryView& memory) const override;
  /// Of the sensor.
  Eigen::Vector3d position(const SampleView& sample, const Eigen::Vector4d& attitude) const;
  Eigen::Vector3d way(const Memory& from, const Eigen::Vector3d& to) const;

  Fields<3> geodetic_, local_, angles_;
  Time every_;
  bool is_in_body_axes_, is_in_ecef_, needs_attitude_;
  Eigen::Vector3d sigma_, lever_arm_;  // m
  double relative_;
  OutputChannel displacement_, velocity_;
  OutputFields<3> d_, d_sigma_, v_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::clone
