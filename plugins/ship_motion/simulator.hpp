// SPDX-License-Identifier: Apache-2.0
// The source: one angle of a ship by its shaping filter, read by a gyro that drifts.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/source.hpp"

namespace binnacle::ship_motion {

/// State: angle, rate, accumulated drift, drift; exact from sample to sample.
class Simulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit Simulator(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override;
  void start(std::uint64_t seed, std::byte* memory) const override;
  SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const override;

  enum Channel { truth, gyro };

 private:
  struct Memory;

  Time interval_, duration_;
  Eigen::Vector4d first_sigma_;
  Eigen::Matrix4d Phi_, root_Q_;  // per interval
  double noise_;                  // rad
  std::vector<ChannelDeclaration> channels_;
};

}  // namespace binnacle::ship_motion
