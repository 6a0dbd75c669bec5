// SPDX-License-Identifier: Apache-2.0
// Lines of a live source as they come, and what is reported of them and of where they come from.
#pragma once

#include "line_input/bytes.hpp"
#include "line_input/label_guard.hpp"

namespace binnacle::line_input {

class Lines {
 public:
  /// `from`, `stamp`, `silence`, `on_error`. The constructor needs `from`.
  static std::vector<ParameterSpec> parameters();
  explicit Lines(const Parameters& parameters, Time max_ahead = 10 * nanoseconds_per_second)
      : bytes_(parameters, true), max_ahead_(max_ahead), labels_(max_ahead) {}

  /// "stamp": "arrival".
  bool stamps_arrival() const { return bytes_.stamps_arrival(); }
  int wait_handle() const { return bytes_.wait_handle(); }
  SourceFigures figures() const;

  /// Throws ComponentError::in_data (B060). What was read before is forgotten.
  void open(Reporter& reporter);

  enum class Got {
    line,
    nothing,  // yet
    end,      // for good
    anew      // what comes next is of another connection, or of none yet
  };
  /// `line`: without its end, valid until the next call.
  Got next(std::string_view& line);

  /// The newest line is no good. The first of a kind is reported at once, then the tenth, the hundredth, … Throws
  /// ComponentError::in_data with "on_error": "stop".
  void complain(const std::string& why, const char* code = "B062");
  /// The label of the newest line. False: it is far ahead (LabelGuard), which was complained of.
  bool accepts(Time label);
  /// It is the first after a jump of the clock.
  bool is_anew() const { return labels_.is_anew(); }
  /// As complain(), of something that ends nothing.
  void note(const std::string& what, const char* code) { bytes_.note(what, code, line_); }

 private:
  bool take_line(std::string_view& line);
  void begin_anew(bool is_lost);

  Bytes bytes_;
  Time max_ahead_;
  LabelGuard labels_;
  std::string buffer_;
  std::size_t begin_ = 0;  // of what was not taken yet
  int line_ = 0;
  bool is_cut_ = false;                      // the rest of a line that was given up
  std::int64_t waiting_ = 0, unusable_ = 0;  // lines
};

}  // namespace binnacle::line_input
