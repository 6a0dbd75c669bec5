// SPDX-License-Identifier: Apache-2.0
// The rtklib_pos source: solution files of RTKLIB, recorded or as they grow.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "line_input/lines.hpp"
#include "solution.hpp"
#include "text/faults.hpp"

namespace binnacle::rtklib {

class PosSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit PosSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;
  int wait_handle() const override { return live_ ? live_->lines.wait_handle() : -1; }
  SourceFigures figures() const override { return live_ ? live_->lines.figures() : SourceFigures{}; }

 private:
  /// Of a connection; outside the arena: what came can not be read again.
  struct Live {
    explicit Live(const Parameters& parameters) : lines(parameters) {}
    line_input::Lines lines;
    Header header;
    Time newest = no_time;
  };

  void read_parameters(const Parameters& parameters);
  void peek();
  void declare_channel();
  /// The layout of a line, from the header or the config. Throws BadLine.
  const Layout& layout_for(const Header& header) const;
  void read_file(text_file::Faults& faults, Reporter& reporter);
  /// False: no solution, and nothing wrong. Throws BadLine.
  std::optional<Solution> take(std::string_view line, Header& header) const;
  SourceStatus next_of_live(SourceOutput& output) const;
  void write(const Solution& solution, SourceOutput& output) const;

  std::string path_;  // recorded
  civil_time::UtcClock clock_;
  std::optional<Layout> stated_;  // by the config, for files without a header
  Layout layout_;                 // of the channel
  Place place_;
  text_file::OnInvalid on_invalid_ = text_file::OnInvalid::skip;
  OutputChannel channel_;
  OutputFields<3> position_, relative_, velocity_, position_sd_, velocity_sd_;
  OutputFields<4> figures_;
  bool has_position_ = true, has_relative_ = false;
  Memory<std::uint64_t> next_;

  struct Row {
    Solution solution;
    int line = 0;
  };
  std::vector<Row> rows_;
  std::unique_ptr<Live> live_;
};

}  // namespace binnacle::rtklib
