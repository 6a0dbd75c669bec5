// SPDX-License-Identifier: Apache-2.0
// The pushed source: a channel that the embedding program fills.
#pragma once

#include "binnacle/registry.hpp"

namespace binnacle::core {

/// Declares a channel and never emits on it: samples come through Session::push(). A run sees an ended source.
class PushedSource : public Source {
 public:
  static ComponentSpec spec();
  explicit PushedSource(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return 0; }
  void start(std::uint64_t /*seed*/, std::byte* /*memory*/) const override {}
  SourceStatus next(std::byte* /*memory*/, SampleSlot* /*slots*/, int& /*channel*/) const override {
    return SourceStatus::wait;
  }

 private:
  std::vector<ChannelDeclaration> channels_;
};

}  // namespace binnacle::core
