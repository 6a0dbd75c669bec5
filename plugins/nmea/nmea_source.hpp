// SPDX-License-Identifier: Apache-2.0
// The nmea source: what a receiver says in sentences of NMEA 0183, recorded or live.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "decoder.hpp"
#include "utc_clock.hpp"

namespace binnacle::nmea {

class NmeaSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit NmeaSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;

 private:
  struct Event {
    std::uint64_t epoch;
    bool is_heading;
  };

  void declare_channels(bool has_sigmas);
  void read_file(Reporter& reporter);
  void write_fix(const Epoch& epoch, SampleWriter& out) const;

  std::string path_;
  UtcClock clock_;
  Decoder::Options options_;
  bool stops_on_error_;
  OutputChannel fix_, heading_;
  OutputFields<3> position_, quality_;
  OutputFields<4> velocity_;
  OutputFields<3> position_sd_;
  bool has_sigmas_;
  OutputField yaw_;
  Memory<std::uint64_t> next_;  // event

  std::vector<Epoch> epochs_;
  std::vector<Event> events_;
};

}  // namespace binnacle::nmea
