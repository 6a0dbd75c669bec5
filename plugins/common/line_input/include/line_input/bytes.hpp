// SPDX-License-Identifier: Apache-2.0
// Bytes of a live source as they come, and what is reported of them and of where they come from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::line_input {

/// Of the machine's monotonic clock.
Time monotonic_now();

/// Whether a source that takes `path` or `from` is live: by `from`. Throws ComponentError where it has both or neither, or a path
/// with "stamp": "arrival".
bool is_live(const Parameters& parameters);
/// `path`, of a file that is there; throws ComponentError::in_data (B060) else.
std::string existing_path(const Parameters& parameters);

class Bytes {
 public:
  /// `from`, `stamp`, `silence`, `on_error`; `unit`: what is left out when it is no good, "a line". The constructor needs
  /// `from`.
  static std::vector<ParameterSpec> parameters(const std::string& unit);
  /// ends_lines: a datagram ends a line, with or without its LF.
  Bytes(const Parameters& parameters, bool ends_lines);
  ~Bytes();

  /// "stamp": "arrival".
  bool stamps_arrival() const { return stamps_arrival_; }
  /// "on_error": "stop".
  bool stops() const { return stops_; }
  int wait_handle() const;
  const std::string& from() const;
  /// Arrival and losses; of what waits and what was no good only who takes the bytes apart knows.
  SourceFigures figures() const;

  /// Throws ComponentError::in_data (B060). What was read before is forgotten.
  void open(Reporter& reporter);

  enum class Got {
    bytes,
    nothing,  // yet
    end,      // for good
    lost,     // what comes next is of another connection
    found     // the connection is there again
  };
  /// Appends what is there. `line`: for warnings.
  Got read(std::string& to, int line = 0);

  /// The first of a kind is reported at once, then the tenth, the hundredth, …
  void note(const std::string& what, const char* code, int line = 0);
  void warn(const std::string& what, const char* code, int line = 0);

 private:
  struct Intake;
  void watch_silence(bool came, int line);
  void watch_losses(int line);

  bool stamps_arrival_ = false, stops_ = false, ends_lines_;
  Time silence_ = 0;
  std::unique_ptr<Intake> intake_;
};

}  // namespace binnacle::line_input
