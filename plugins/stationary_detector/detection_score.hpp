// SPDX-License-Identifier: Apache-2.0
// The detection_score transform: for how many seconds a detector missed what was, and told what was not.
#pragma once

#include <vector>

#include "binnacle/source.hpp"

namespace binnacle::stationary_detector {

/// Time is counted by what truth and detector have said last; it speaks at each sample of the truth.
class DetectionScore final : public Transform {
 public:
  static ComponentSpec spec();
  explicit DetectionScore(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override;
  void start(std::uint64_t seed, std::byte* memory) const override;
  void on(int input, const SampleView& sample, std::byte* memory, Emitter& emitter) const override;

 private:
  struct Memory;
  Time after_;
  std::vector<ChannelDeclaration> channels_;
};

}  // namespace binnacle::stationary_detector
