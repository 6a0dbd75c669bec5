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

  SourceStatus next(const MemoryView& /*memory*/, SourceOutput& /*out*/) const override { return SourceStatus::wait; }
};

}  // namespace binnacle::core
