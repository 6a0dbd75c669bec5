// SPDX-License-Identifier: Apache-2.0
// Lines of a live source as they come, and what is reported of them and of where they come from.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::line_input {

/// Of the machine's monotonic clock.
Time monotonic_now();

class Lines {
 public:
  /// `from`, `stamp`, `silence`, `on_error`. The constructor needs `from`.
  static std::vector<ParameterSpec> parameters();
  explicit Lines(const Parameters& parameters);
  ~Lines();

  /// "stamp": "arrival".
  bool stamps_arrival() const { return stamps_arrival_; }
  int wait_handle() const;
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
  /// The same of something that ends nothing.
  void note(const std::string& what, const char* code);

 private:
  struct Intake;
  void watch_silence(bool came);
  void watch_losses();
  bool take_line(std::string_view& line);

  bool stamps_arrival_ = false, stops_ = false;
  Time silence_ = 0;
  std::unique_ptr<Intake> intake_;
};

}  // namespace binnacle::line_input
