// SPDX-License-Identifier: Apache-2.0
// Endpoint: bytes as they come, never waited for.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "address/address.hpp"
#include "address/descriptor.hpp"

namespace binnacle::line_input {

/// A file is followed as it grows. A connection or a device that is lost is tried again each second; a pipe ends.
class Endpoint {
 public:
  explicit Endpoint(address::Address address) : address_(std::move(address)) {}
  ~Endpoint();
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;

  /// Throws ComponentError::in_data (B060) where the file or device is not there, or the port is another's.
  void open();

  enum class Got {
    bytes,
    nothing,  // yet
    end,      // for good
    lost,     // what comes next begins anew; once
    found     // again, or for the first time where nobody was there at first; once
  };
  /// Appends what is there. ends_lines: a datagram ends a line.
  Got read(std::string& to, bool ends_lines);
  /// For poll(); −1: it is asked now and then.
  int wait_handle() const;
  const address::Address& address() const { return address_; }
  /// Datagrams that came faster than they were read, so far.
  std::int64_t lost() const { return lost_; }

 private:
  using Clock = std::chrono::steady_clock;
  [[noreturn]] void fail(const std::string& why) const;
  void open_file();
  void open_serial();
  void open_udp();
  bool connect();
  Got come_back();
  Got finish_connecting();
  Got found();
  long receive(char* to, std::size_t size);
  Got lose();

  address::Address address_;
  address::Descriptor file_;    // what is read
  address::Descriptor server_;  // of a TCP server
  bool is_regular_ = false, is_connecting_ = false, was_lost_ = false;
  Clock::time_point next_try_{};
  std::int64_t lost_ = 0;
};

}  // namespace binnacle::line_input
