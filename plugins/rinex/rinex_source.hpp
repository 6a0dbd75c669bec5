// SPDX-License-Identifier: Apache-2.0
// The rinex source: recorded observations and broadcast messages as channels.
#pragma once

#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "navigation_file.hpp"
#include "observation_file.hpp"

namespace binnacle::rinex {

class RinexSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit RinexSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;

 private:
  enum class Kind { observations, ephemerides, klobuchar };
  struct Event {
    Time t;
    Kind kind;
    std::size_t index;
  };

  void arrange(Time first, Time last);
  void report_orphans(Faults& faults) const;

  std::string observation_path_, navigation_path_;
  Signals signals_;
  int origin_week_ = 0;
  OnInvalid on_invalid_ = OnInvalid::skip;
  gnss::ChoiceRules rules_;
  Time from_, to_;
  gnss::ObservationChannels channels_;
  Memory<std::uint64_t> next_;  // event

  std::vector<Epoch> epochs_;
  Navigation navigation_;
  std::vector<gnss::MessageSet> sets_;
  std::vector<Event> events_;  // in the order in which they are emitted
};

}  // namespace binnacle::rinex
