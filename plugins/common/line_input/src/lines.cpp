// SPDX-License-Identifier: Apache-2.0
#include "line_input/lines.hpp"

#include <algorithm>
#include <utility>

namespace binnacle::line_input {

namespace {

/// A line that is longer is no line.
constexpr std::size_t longest_line = 1 << 20;

}  // namespace

std::vector<ParameterSpec> Lines::parameters() { return Bytes::parameters("a line"); }

SourceFigures Lines::figures() const {
  SourceFigures figures = bytes_.figures();
  figures.waiting = waiting_;
  figures.unusable = unusable_;
  return figures;
}

void Lines::open(Reporter& reporter) {
  buffer_.clear();
  begin_ = 0;
  line_ = 0;
  is_cut_ = false;
  waiting_ = unusable_ = 0;
  labels_ = LabelGuard(max_ahead_);
  bytes_.open(reporter);
}

Lines::Got Lines::next(std::string_view& line) {
  for (;;) {
    if (take_line(line)) return Got::line;
    buffer_.erase(0, begin_);
    begin_ = 0;
    if (buffer_.size() > longest_line) {
      buffer_.clear();
      is_cut_ = true;
      complain("it has no end within a megabyte");
    }
    const std::size_t before = buffer_.size();
    switch (bytes_.read(buffer_, line_)) {
      case Bytes::Got::bytes:
        waiting_ += std::count(buffer_.begin() + static_cast<std::ptrdiff_t>(before), buffer_.end(), '\n');
        break;
      case Bytes::Got::nothing: return Got::nothing;
      case Bytes::Got::end:
        if (buffer_.empty()) return Got::end;
        buffer_ += '\n';  // the last line may lack its end
        ++waiting_;
        break;
      case Bytes::Got::lost: begin_anew(true); return Got::anew;
      case Bytes::Got::found: begin_anew(false); return Got::anew;
    }
  }
}

void Lines::begin_anew(bool is_lost) {
  if (!buffer_.empty()) complain("the connection was lost in the middle of it");
  buffer_.clear();
  bytes_.warn(is_lost ? "there is no connection, or it was lost; the program tries again every second"
                      : "the connection is restored",
              "B067", line_);
}

/// A whole one that is not empty.
bool Lines::take_line(std::string_view& line) {
  for (;;) {
    const auto end = buffer_.find('\n', begin_);
    if (end == std::string::npos) return false;
    line = std::string_view(buffer_).substr(begin_, end - begin_);
    begin_ = end + 1;
    ++line_;
    --waiting_;
    if (std::exchange(is_cut_, false)) continue;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \t") != line.npos) return true;
  }
}

bool Lines::accepts(Time label) {
  const bool is_accepted = labels_.accepts(label, monotonic_now());
  if (!is_accepted) complain("its time is far ahead of those before");
  return is_accepted;
}

void Lines::complain(const std::string& why, const char* code) {
  ++unusable_;
  if (bytes_.stops()) throw ComponentError::in_data("the line is invalid: " + why, bytes_.from(), line_, code);
  note("a line is invalid: " + why, code);
}

}  // namespace binnacle::line_input
