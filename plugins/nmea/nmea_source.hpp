// SPDX-License-Identifier: Apache-2.0
// The nmea source: what a receiver says in sentences of NMEA 0183, recorded or live.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "decoder.hpp"
#include "live_epochs.hpp"

namespace binnacle::nmea {

class NmeaSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit NmeaSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;
  int wait_handle() const override { return live_ ? live_->wait_handle() : -1; }
  SourceFigures figures() const override { return live_ ? live_->figures() : SourceFigures{}; }

 private:
  enum class Part { fix, heading, attitude };
  struct Event {
    std::uint64_t epoch;
    Part part;
  };

  /// Live: what came and was not emitted yet.
  struct Waiting {
    std::vector<Epoch> epochs;
    std::vector<Event> events;
    std::size_t next = 0;
  };

  static std::vector<Event> events_of(const std::vector<Epoch>& epochs);
  void declare_channels(bool has_sigmas);
  SourceStatus next_of_live(SourceOutput& output) const;
  void write(const Epoch& epoch, Part part, SourceOutput& output) const;
  void read_file(Reporter& reporter);
  void write_fix(const Epoch& epoch, SampleWriter& out) const;

  std::string path_;  // recorded
  UtcClock clock_;
  Decoder::Options options_;
  bool stops_on_error_;
  OutputChannel fix_, heading_, attitude_;
  OutputFields<3> position_;
  OutputFields<6> quality_;
  OutputFields<9> attitude_fields_;
  OutputFields<4> velocity_;
  OutputFields<3> position_sd_;
  bool has_sigmas_;
  OutputField yaw_;
  Memory<std::uint64_t> next_;  // event

  std::vector<Epoch> epochs_;
  std::vector<Event> events_;
  // Outside the arena: what came can not be read again.
  std::unique_ptr<LiveEpochs> live_;
  std::unique_ptr<Waiting> waiting_ = std::make_unique<Waiting>();
};

}  // namespace binnacle::nmea
