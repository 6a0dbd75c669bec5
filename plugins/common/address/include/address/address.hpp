// SPDX-License-Identifier: Apache-2.0
// Where live samples come from and go to, as one text: "udp://:5005", "serial:///dev/ttyUSB0?baud=115200".
#pragma once

#include <string>

namespace binnacle::address {

enum class Kind { standard_input, standard_output, file, tcp_client, tcp_server, udp, serial };
enum class Direction { input, output };

/// A text is one of
///
///     stdin:                            input only
///     stdout:                           output only
///     file:PATH
///     tcp://HOST:PORT                   connects
///     tcp://:PORT                       a server on loopback
///     tcp://HOST:PORT?server            a server on that interface; 0.0.0.0 or [::] for all
///     udp://:PORT                       input: receives on loopback; output: sends to it
///     udp://HOST:PORT                   input: receives on that interface, 0.0.0.0 or [::] for all; output: sends to HOST
///     serial:///dev/NAME?baud=115200    or a pseudo-terminal; without baud 115200
struct Address {
  Kind kind = Kind::file;
  std::string text;  // as it was given, for messages
  std::string path;  // of a file or a serial device
  std::string host;  // of tcp and udp; "127.0.0.1" where none was given; IPv6 without its brackets
  int port = 0;
  int baud = 0;
};

/// The text is that of a parameter::path, so that the file of `file:` is looked for beside the config, as every path is.
/// Throws ComponentError at `pointer` that states what was found, what was expected, and what was most likely meant.
Address parse(const std::string& text, Direction direction, const std::string& pointer);

}  // namespace binnacle::address
