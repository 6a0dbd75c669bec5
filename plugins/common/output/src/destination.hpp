// SPDX-License-Identifier: Apache-2.0
// Where the worker's lines go: one receiver, or the clients of a server.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <poll.h>

#include "address/address.hpp"

namespace binnacle::text_output {

using Clock = std::chrono::steady_clock;

/// `code`: B145 (lines were lost) or B146 (a connection broke).
using Warn = std::function<void(const char* code, std::string message)>;

class Destination {
 public:
  virtual ~Destination() = default;

  virtual void add(std::string_view line) = 0;
  /// Sends, connects, takes clients: what goes without waiting. `ready`: what poll() said of what watch() gave; null at first.
  virtual void serve(const pollfd* ready) = 0;
  /// Appends what serve() waits for.
  virtual void watch(std::vector<pollfd>& descriptors) const = 0;
  /// When serve() has something to do though no descriptor is ready.
  virtual Clock::time_point wakes_at() const { return Clock::time_point::max(); }
  /// Bytes that are not sent yet and have a receiver.
  virtual std::size_t waiting() const = 0;
  /// At the end: what was lost.
  virtual void conclude() = 0;
};

/// Opens it. Throws std::runtime_error with the reason where it cannot be.
std::unique_ptr<Destination> make_single(const address::Address& address, std::size_t buffer, Warn warn);
std::unique_ptr<Destination> make_server(const address::Address& address, std::size_t buffer, Warn warn);

/// "12 of 340 lines were lost".
std::string loss_text(std::int64_t lost, std::int64_t lines);

}  // namespace binnacle::text_output
