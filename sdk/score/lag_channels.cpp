// SPDX-License-Identifier: Apache-2.0
// In every run: the channels NAME.smoothed that have a subscriber.
#include <list>

#include "binnacle/run.hpp"
#include "plan.hpp"
#include "smooth/lag_channel.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

class LagChannels final : public binnacle::RunObserver {
 public:
  explicit LagChannels(const ScorePlan& plan) : plan_(plan) {}

  void begin(Session& session) override {
    for (const SmoothingPlan& smoothing : plan_.smoothings) {
      if (!smoothing.lag) continue;
      const ChannelId channel = session.channel(plan_.filters[as_size(smoothing.as)].name);
      if (session.composition().channels()[as_size(channel.index)].subscribers.empty()) continue;
      channels_.emplace_back(session, FilterId{smoothing.of}, channel, *smoothing.lag);
    }
  }
  void after_instant() override {
    for (auto& channel : channels_) channel.emit();
  }
  void exchange(StateBytes& bytes) override {
    for (auto& channel : channels_) channel.exchange(bytes);
  }
  void finished() override {
    for (auto& channel : channels_) channel.finish();
  }

 private:
  const ScorePlan& plan_;
  std::list<smooth::LagChannel> channels_;
};

}  // namespace

std::shared_ptr<binnacle::RunObserver> ScorePlan::part() const {
  const bool has_lag = std::ranges::any_of(smoothings, [](const auto& smoothing) { return bool(smoothing.lag); });
  return has_lag ? std::make_shared<LagChannels>(*this) : nullptr;
}

}  // namespace binnacle::score
