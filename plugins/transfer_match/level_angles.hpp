// SPDX-License-Identifier: Apache-2.0
// A body's attitude angles, told as those of the axes in which it is mounted.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::transfer_match {

/// C_nr = C_nb C_rbᵀ, `mounting` being roll, pitch, yaw of C_rb. Roll and yaw of a body that stands upright are one turn;
/// those of the axes r are not. Goes with `mounting` of phi_error/attitude: truth and initial values in the same axes.
class LevelAngles final : public Transform {
 public:
  static ComponentSpec spec();
  explicit LevelAngles(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return 0; }
  void on(int input, const SampleView& sample, std::byte* memory, Emitter& emitter) const override;

 private:
  std::vector<ChannelDeclaration> channels_;
  Eigen::Vector4d q_br_;
};

}  // namespace binnacle::transfer_match
