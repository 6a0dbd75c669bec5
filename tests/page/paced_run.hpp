// SPDX-License-Identifier: Apache-2.0
// PacedRun: a simulated drive with its page, which goes as far as a test lets it; and a client without manners.
#pragma once

#include <string>
#include <vector>

#include "command.hpp"

namespace binnacle::test {

/// `binnacle run --page 0` over the quickstart's drive of 195 s.
class PacedRun {
 public:
  explicit PacedRun(const std::vector<std::string>& more_arguments = {});

  /// Full speed until t [s]; from there on a hundredth of a second of data takes two of the clock.
  void open_until(double t) const;
  void open() const { open_until(1e9); }
  /// Until the run is held up at t [s], which it is open until.
  void wait_until_held(double t);
  Outcome wait() { return command_.wait(); }
  void kill() { command_.signal(9); }

  int port() const { return port_; }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  std::string url() const { return "http://" + host() + "/"; }
  const Workbench& bench() const { return bench_; }

 private:
  Workbench bench_;
  Command command_;
  int port_ = 0;
};

/// A TCP connection to 127.0.0.1. Reading gives up after half a minute.
class Client {
 public:
  explicit Client(int port, int receive_buffer = 0);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void send(const std::string& text) const;
  /// Until the other side closes.
  std::string rest() const;
  /// Until `mark` came.
  std::string until(const std::string& mark);

 private:
  int socket_ = -1;
  std::string received_;
};

/// What a request gets.
std::string answer(int port, const std::string& request);

}  // namespace binnacle::test
