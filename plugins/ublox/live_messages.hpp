// SPDX-License-Identifier: Apache-2.0
// Messages of a receiver that is connected.
#pragma once

#include <deque>
#include <map>
#include <vector>

#include "line_input/bytes.hpp"
#include "recording.hpp"

namespace binnacle::ublox {

/// A sample that waits to be emitted.
struct LiveSample {
  Recording::Part part = Recording::Part::values;
  Item item;
  gnss::MessageSet set;                          // of Part::ephemerides
  std::vector<gnss::BroadcastMessage> messages;  // to which its indices belong
};

class LiveMessages {
 public:
  LiveMessages(const Parameters& parameters, const ReadingRules& rules);

  void open(Reporter& reporter);
  int wait_handle() const { return bytes_.wait_handle(); }
  SourceFigures figures() const;

  /// sample: `sample` is the next one. wait: none so far; end: there will be no more.
  SourceStatus next(LiveSample& sample);

 private:
  class Notes;
  void take(Item& item);
  void take_broadcast(const Item& item);
  /// The set that observations at `t` need, if it is another one.
  void renew_set(Time t);
  void report_counts();

  ReadingRules rules_;
  line_input::Bytes bytes_;
  Framer framer_;
  Decoder decoder_;
  Framer::Counts told_;
  std::map<int, std::uint64_t> told_passed_over_;
  std::deque<LiveSample> waiting_;
  std::map<Kind, Time> newest_;
  std::vector<gnss::BroadcastMessage> messages_;
  std::vector<gnss::Ephemeris> last_set_;
  gnss::ObservationEpoch last_epoch_;
  std::int64_t unusable_ = 0;
  bool is_over_ = false;
};

}  // namespace binnacle::ublox
