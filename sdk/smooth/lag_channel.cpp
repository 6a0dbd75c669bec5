// SPDX-License-Identifier: Apache-2.0
#include "smooth/lag_channel.hpp"

#include "binnacle/composition.hpp"

namespace binnacle::smooth {

LagChannel::LagChannel(Session& session, FilterId filter, ChannelId channel, Lag lag)
    : session_(session),
      filter_(filter),
      channel_(channel),
      epochs_(session.composition().filters()[static_cast<std::size_t>(filter.index)]),
      lag_(session, filter, lag, [this](const Epoch& epoch) { epochs_.push_back(epoch); }) {
  session_.attach_section(filter_, &lag_);
}

LagChannel::~LagChannel() { session_.attach_section(filter_, nullptr); }

void LagChannel::emit() {
  for (std::size_t i = 0; i < epochs_.count(); ++i) {
    const Epoch epoch = epochs_[i];
    session_.push_estimates(channel_, filter_, epoch.t, epoch.x, epoch.P);
  }
  epochs_.clear();
}

void LagChannel::finish() {
  lag_.finish();
  emit();
}

}  // namespace binnacle::smooth
