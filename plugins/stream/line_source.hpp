// SPDX-License-Identifier: Apache-2.0
// What the sources of lines share: the address, the channels, the stamps, and what becomes of lines that are no good.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/source.hpp"
#include "line_input/lines.hpp"

namespace binnacle::stream {

/// A field of a channel, and what it is called in a line.
struct FieldPlan {
  std::string key;
  double scale = 1;  // to SI
};

struct ChannelPlan {
  std::string name;  // in a line; "": there is one channel
  OutputChannel output;
  std::vector<FieldPlan> fields;
  bool has_intervals = false;  // some of its fields are rates or increments
};

/// A line that is no good.
struct BadLine {
  std::string why;
};

/// A sample as it stood in a line: numbers in its own units, NaN where there is none.
struct LineSample {
  std::size_t channel = 0;
  Time t = no_time, t0 = no_time;
  std::vector<double> values;
};

class LineSource : public Source {
 public:
  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override;
  int wait_handle() const override { return lines_->wait_handle(); }
  SourceFigures figures() const override { return lines_->figures(); }

 protected:
  /// `from`, `stamp`, `silence`, `time`, `interval`, `max_gap`, `max_ahead`, `on_error`.
  static void add_parameters(ComponentSpec& spec);
  explicit LineSource(const Binding& binding);
  static ParameterSpec field_spec(const char* key, const char* about);
  /// A channel from a map of fields.
  void add_channel(const std::string& name, const std::vector<std::pair<std::string, ParameterValue>>& fields,
                   const char* key);
  /// Nanoseconds of a label as it is written.
  Time time_of(std::string_view text) const;

  /// False: the line carries no sample, and there is nothing wrong with it. Throws BadLine.
  virtual bool parse(std::string_view line, LineSample& sample) const = 0;
  /// What comes next is of another connection.
  virtual void begin_anew() const {}

  std::vector<ChannelPlan> channels_;
  std::string time_key_ = "t";

 private:
  bool take(std::string_view line, SourceOutput& out) const;
  void write(const LineSample& sample, SourceOutput& out) const;

  std::int64_t time_unit_ = nanoseconds_per_second;
  Time time_offset_ = 0;
  std::optional<Time> interval_;
  Time max_gap_ = nanoseconds_per_second;
  // Outside the arena: what was read can not be read again.
  std::unique_ptr<line_input::Lines> lines_;
  struct Newest {
    std::vector<Time> times;  // by channel
    LineSample sample;
  };
  std::unique_ptr<Newest> newest_ = std::make_unique<Newest>();
};

}  // namespace binnacle::stream
