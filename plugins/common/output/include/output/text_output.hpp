// SPDX-License-Identifier: Apache-2.0
// Lines of text to standard output, a file, UDP, TCP clients, a TCP server, a serial device or a pseudo-terminal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "address/address.hpp"
#include "address/descriptor.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/source.hpp"
#include "binnacle/state_bytes.hpp"

namespace binnacle::text_output {

class Worker;

/// What a sink that writes lines has. A receiver that is slow, comes or goes never holds the run up: each has a buffer, of which
/// the oldest lines go when it is full; they are counted (B145). A regular file alone is written in the call itself, and
/// loses nothing.
class TextOutput {
 public:
  /// `to` and `buffer`.
  static std::vector<ParameterSpec> parameters();

  /// Opens nothing. Throws ComponentError where the address is none.
  explicit TextOutput(const Parameters& parameters);
  ~TextOutput();

  void report_to(Reporter& reporter) { reporter_ = &reporter; }
  /// Throws ComponentError at "/to" where it cannot be opened.
  void open();
  /// `line` ends with its only newline. Neither waits nor allocates, unless there is a warning to report.
  void write(std::string_view line);
  /// Of a run that keeps checkpoints: a file is cut back to where it was. What was sent to all else is gone.
  /// Throws ComponentError::in_data where the file is not what it was.
  void exchange(StateBytes& bytes);
  /// Sends what waits as long as the receiver reads, and reports what was lost.
  void close();

 private:
  bool open_file();
  void empty_file();
  void write_file(std::string_view line);
  void warn(const char* code, const std::string& message);
  void pass_warnings();

  address::Address address_;
  std::size_t buffer_;
  Reporter* reporter_ = nullptr;
  address::Descriptor file_;  // a regular file
  bool is_old_ = false;       // what an earlier run wrote to it is still there
  std::int64_t lines_ = 0;    // of a file
  std::int64_t lost_ = 0;
  bool is_cut_ = false;  // the last line of the file has no end
  std::unique_ptr<Worker> worker_;
};

}  // namespace binnacle::text_output
