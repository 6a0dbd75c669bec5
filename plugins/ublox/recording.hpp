// SPDX-License-Identifier: Apache-2.0
// A file of messages, read whole.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "binnacle/source.hpp"
#include "decoder.hpp"

namespace binnacle::ublox {

/// Samples in order of time, on the clock of channels; each kind's times increase.
struct Recording {
  enum class Part { klobuchar, ephemerides, values, observations };
  struct Event {
    Time t;
    Part part;
    std::size_t index;
  };

  std::vector<Item> items;  // whose samples are numbers
  std::vector<gnss::ObservationEpoch> epochs;
  std::vector<gnss::BroadcastMessage> messages;
  std::vector<gnss::MessageSet> sets;
  std::vector<std::pair<Time, gnss::Klobuchar>> klobuchar;
  std::vector<Event> events;
};

struct ReadingRules {
  Decoder::Options decoder;
  gnss::ChoiceRules messages;
  bool stops_on_error = false;
  std::vector<std::string> asked_for;  // messages that the config names
};

/// Throws ComponentError::in_data where nothing is in it.
Recording read_recording(const std::string& path, const ReadingRules& rules, Reporter& reporter);

/// Puts an item on the clock of channels.
void put_on_clock(Item& item, const Decoder& decoder, const civil_time::UtcClock& clock);

}  // namespace binnacle::ublox
