// SPDX-License-Identifier: Apache-2.0
// The detection_score transform: for how many seconds a detector missed what was, and reported what was not.
#pragma once

#include "binnacle/source.hpp"

namespace binnacle::stationary_detector {

/// Time is counted by what truth and detector have said last; it emits at each sample of the truth.
class DetectionScore final : public Transform {
 public:
  static ComponentSpec spec();
  explicit DetectionScore(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  struct Memory;
  Time after_;
  Input detected_, truth_;
  Field says_standing_, is_standing_;
  OutputChannel channel_;
  OutputField missed_, false_, standing_, moving_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::stationary_detector
