// SPDX-License-Identifier: Apache-2.0
// The ublox source: what a u-blox receiver says in the UBX protocol, recorded or live.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "binnacle/source.hpp"
#include "live_messages.hpp"
#include "recording.hpp"

namespace binnacle::ublox {

class UbloxSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit UbloxSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;
  int wait_handle() const override { return live_ ? live_->wait_handle() : -1; }
  SourceFigures figures() const override { return live_ ? live_->figures() : SourceFigures{}; }

 private:
  void choose_messages(const Parameters& parameters);
  void declare_channels();
  SourceStatus next_of_live(SourceOutput& output) const;
  void write(const Item& item, SourceOutput& output) const;

  std::string path_;  // recorded
  ReadingRules rules_;
  bool has_satellites_ = false;
  std::array<OutputChannel, kind_count> channels_;  // by Kind, of those whose samples are numbers
  gnss::ObservationChannels satellites_;
  Memory<std::uint64_t> next_;  // event

  Recording recording_;
  // Outside the arena: what came can not be read again.
  std::unique_ptr<LiveMessages> live_;
};

}  // namespace binnacle::ublox
