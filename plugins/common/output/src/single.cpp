// SPDX-License-Identifier: Apache-2.0
// One receiver: standard output, a pipe, UDP, a TCP server that is connected to, a serial device.
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "address/serial.hpp"
#include "address/socket.hpp"
#include "connection.hpp"
#include "destination.hpp"

namespace binnacle::text_output {

namespace {

using namespace std::chrono_literals;
using address::Address;
using address::Descriptor;
using address::Kind;

constexpr auto between_tries = 1s;
constexpr auto longest_connect = 5s;  // before the run

std::runtime_error cannot_be_opened() {
  return std::runtime_error(std::string("cannot be opened: ") + std::strerror(errno));
}

Descriptor checked(address::Socket socket) {
  if (!socket.descriptor) throw std::runtime_error(socket.fault);
  return std::move(socket.descriptor);
}

/// Descriptor 1 anew, so that it does not block here and is as it was for others that share it. A socket cannot be
/// opened anew and has flags for each call.
Descriptor open_standard_output() {
  Descriptor output(::open("/proc/self/fd/1", O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY));
  if (!output) output = Descriptor(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0));
  return output;
}

/// Of a TCP client the connection may not be there yet.
Descriptor open_now(const Address& address) {
  Descriptor descriptor;
  switch (address.kind) {
    case Kind::tcp_client: return checked(address::connect_tcp(address));
    case Kind::udp: return checked(address::connect_udp(address));
    case Kind::serial: descriptor = address::open_serial(address); break;
    case Kind::standard_output: descriptor = open_standard_output(); break;
    default: descriptor = Descriptor(::open(address.path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY));
  }
  if (!descriptor) throw cannot_be_opened();
  return descriptor;
}

Connection::Way way_of(const Address& address) {
  struct stat status {};
  if (address.kind == Kind::udp) return Connection::Way::datagrams;
  const bool is_socket =
      address.kind == Kind::tcp_client ||
      (address.kind == Kind::standard_output && ::fstat(STDOUT_FILENO, &status) == 0 && S_ISSOCK(status.st_mode));
  return is_socket ? Connection::Way::stream_socket : Connection::Way::stream;
}

class Single final : public Destination {
 public:
  Single(const Address& address, std::size_t buffer, Warn warn)
      : address_(address), connection_(way_of(address), buffer), warn_(std::move(warn)) {
    Descriptor descriptor = open_now(address_);
    if (address_.kind == Kind::tcp_client) wait_for(descriptor.get());
    connection_.attach(std::move(descriptor));
  }

  void add(std::string_view line) override { connection_.add(line); }

  void serve(const pollfd* ready) override {
    if (!connection_.is_open()) return try_again();
    const short events = ready ? ready->revents : short{0};
    if (is_connecting_) {
      if ((events & (POLLOUT | POLLERR | POLLHUP)) == 0) return;
      if (const auto fault = address::connect_fault(connection_.descriptor()); !fault.empty()) return lose(fault);
      is_connecting_ = false;
    }
    std::string fault;
    if (address_.kind == Kind::udp && (events & POLLERR) != 0)
      if (const auto refusal = connection_.take_refusal(); !refusal.empty()) lose(refusal);
    if (address_.kind == Kind::tcp_client && (events & (POLLIN | POLLHUP)) != 0) fault = connection_.read_and_forget();
    if (fault.empty()) fault = connection_.send();
    if (fault.empty() && (events & (POLLHUP | POLLERR)) != 0 && address_.kind != Kind::udp) fault = "it has gone";
    if (!fault.empty()) lose(fault);
  }

  void watch(std::vector<pollfd>& descriptors) const override {
    if (!connection_.is_open()) return;
    const int reads = address_.kind == Kind::tcp_client ? POLLIN : 0;
    const int writes = is_connecting_ || connection_.waiting() > 0 ? POLLOUT : 0;
    descriptors.push_back({connection_.descriptor(), static_cast<short>(reads | writes), 0});
  }

  Clock::time_point wakes_at() const override {
    return connection_.is_open() || !is_tried_again() ? Clock::time_point::max() : next_try_;
  }

  std::size_t waiting() const override { return connection_.is_open() ? connection_.waiting() : 0; }

  void conclude() override {
    if (connection_.unsent() == 0) return;
    std::string why = ": the receiver was too slow; use a larger 'buffer', or a file, which loses no lines";
    if (interruptions_ > 0) {
      why = ": " + first_fault_;
      if (interruptions_ > 1) why += ", the first of " + std::to_string(interruptions_) + " faults";
    }
    warn_("B145", loss_text(connection_.unsent(), connection_.lines()) + why);
  }

 private:
  bool is_tried_again() const { return address_.kind == Kind::tcp_client || address_.kind == Kind::serial; }

  void wait_for(int descriptor) const {
    pollfd writable{descriptor, POLLOUT, 0};
    if (::poll(&writable, 1, static_cast<int>(std::chrono::milliseconds(longest_connect).count())) == 0)
      throw std::runtime_error("cannot connect: no answer");
    if (const auto fault = address::connect_fault(descriptor); !fault.empty()) throw std::runtime_error(fault);
  }

  void try_again() {
    if (!is_tried_again() || Clock::now() < next_try_) return;
    next_try_ = Clock::now() + between_tries;
    try {
      connection_.attach(open_now(address_));
      is_connecting_ = address_.kind == Kind::tcp_client;
    } catch (const std::runtime_error&) {  // again in a second
    }
  }

  void lose(const std::string& fault) {
    const bool was_connecting = std::exchange(is_connecting_, false);
    if (address_.kind != Kind::udp) connection_.attach({});
    next_try_ = Clock::now() + between_tries;
    if (was_connecting) return;
    if (interruptions_++ > 0) return;
    first_fault_ = fault;
    warn_("B146", fault + (is_tried_again()
                               ? "; the program tries again every second, and lines that do not fit the buffer are lost"
                           : address_.kind == Kind::udp ? "; lines are lost until a receiver connects"
                                                        : "; all further lines are lost"));
  }

  Address address_;
  Connection connection_;
  Warn warn_;
  bool is_connecting_ = false;
  Clock::time_point next_try_ = Clock::time_point::max();
  std::int64_t interruptions_ = 0;
  std::string first_fault_;
};

}  // namespace

std::string loss_text(std::int64_t lost, std::int64_t lines) {
  return std::to_string(lost) + " of " + std::to_string(lines) + (lines == 1 ? " line was lost" : " lines were lost");
}

std::unique_ptr<Destination> make_single(const Address& address, std::size_t buffer, Warn warn) {
  return std::make_unique<Single>(address, buffer, std::move(warn));
}

}  // namespace binnacle::text_output
