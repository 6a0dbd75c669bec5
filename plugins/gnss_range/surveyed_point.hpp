// SPDX-License-Identifier: Apache-2.0
// A place that is known: the reference of a receiver that stands still.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "binnacle/source.hpp"

namespace binnacle::gnss_range {

/// Says the same place whenever its input speaks.
class SurveyedPoint final : public Transform {
 public:
  static ComponentSpec spec();
  explicit SurveyedPoint(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return 0; }
  void on(int input, const SampleView& sample, std::byte* memory, Emitter& emitter) const override;

 private:
  std::vector<ChannelDeclaration> channels_;
  Eigen::Vector3d ecef_, lla_;
};

}  // namespace binnacle::gnss_range
