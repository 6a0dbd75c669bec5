// SPDX-License-Identifier: Apache-2.0
// IMU samples in other axes: the fixed rotation from sensor to vehicle axes.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// ω' = C ω, f' = C f with C = mounting_rotation. Mean rates of an interval are linear in its increments, so rotating
/// the rates is exact for a channel of increments too.
class RotateAxes final : public Transform {
 public:
  static ComponentSpec spec();
  explicit RotateAxes(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return 0; }
  void on(int input, const SampleView& sample, std::byte* memory, Emitter& emitter) const override;

 private:
  /// C_nb′ = C_nb Cᵀ, and for an IMU that is mounted along the vehicle's axes C_v^b′ = C C_v^b, C_v^b = exp(−[ζ×]).
  void on_truth(const SampleView& sample, Emitter& emitter) const;

  std::vector<ChannelDeclaration> channels_;
  Eigen::Matrix3d C_;
};

}  // namespace binnacle::frames
