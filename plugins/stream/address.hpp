// SPDX-License-Identifier: Apache-2.0
// Where lines come from: "stdin:", "file:PATH", "tcp://HOST:PORT", "tcp://:PORT", "udp://:PORT", "serial:///dev/ttyUSB0?baud=115200".
#pragma once

#include <string>

namespace binnacle::stream {

struct Address {
  enum class Scheme { standard_input, file, tcp, udp, serial } scheme = Scheme::standard_input;
  std::string text;  // as it was written
  std::string path;  // of a file or a device
  std::string host;  // empty: it is the loopback interface, and takes what comes
  int port = 0;
  int baud = 115200;
};

/// Throws ComponentError at "/from" that says what is wrong and what is expected.
Address parse_address(const std::string& text);

}  // namespace binnacle::stream
