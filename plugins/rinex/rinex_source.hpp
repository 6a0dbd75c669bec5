// SPDX-License-Identifier: Apache-2.0
// The rinex source: recorded observations and broadcast messages as channels.
#pragma once

#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "message_choice.hpp"
#include "observation_file.hpp"

namespace binnacle::rinex {

class RinexSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit RinexSource(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  void open(Reporter& reporter) override;
  std::size_t memory_bytes() const noexcept override { return sizeof(std::uint64_t); }
  void start(std::uint64_t seed, std::byte* memory) const override;
  SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const override;

 private:
  enum Channel { observations, ephemerides, klobuchar };
  struct Event {
    Time t;
    Channel channel;
    std::size_t index;
  };

  bool takes(gnss::SatelliteKey key) const;
  void arrange(Time first, Time last);
  void report_orphans(Faults& faults) const;

  std::string observation_path_, navigation_path_;
  Signals signals_;
  int origin_week_ = 0;
  OnInvalid on_invalid_ = OnInvalid::skip;
  ChoiceRules rules_;
  Time from_, to_;
  std::vector<ChannelDeclaration> channels_;

  std::vector<Epoch> epochs_;
  Navigation navigation_;
  std::vector<MessageSet> sets_;
  std::vector<Event> events_;  // in the order in which they are emitted
};

}  // namespace binnacle::rinex
