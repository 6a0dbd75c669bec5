// SPDX-License-Identifier: Apache-2.0
#include "endpoint.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "address/serial.hpp"
#include "address/socket.hpp"
#include "binnacle/parameters.hpp"

namespace binnacle::line_input {

using address::Kind;

namespace {

constexpr std::chrono::seconds between_tries{1};

}  // namespace

/// Standard input stays open: it is not the endpoint's own.
Endpoint::~Endpoint() {
  if (file_.get() == STDIN_FILENO) file_.release();
}

void Endpoint::fail(const std::string& why) const { throw ComponentError::in_data(why, address_.text, 0, "B060"); }

void Endpoint::open() {
  switch (address_.kind) {
    case Kind::standard_input:
      file_ = address::Descriptor(STDIN_FILENO);
      ::fcntl(STDIN_FILENO, F_SETFL, ::fcntl(STDIN_FILENO, F_GETFL) | O_NONBLOCK);
      break;
    case Kind::file: open_file(); break;
    case Kind::serial: open_serial(); break;
    case Kind::udp: open_udp(); break;
    case Kind::tcp_client: connect(); break;
    case Kind::tcp_server: {
      address::Socket socket = address::serve_tcp(address_);
      if (!socket.descriptor) fail("port " + std::to_string(address_.port) + " cannot be opened: " + socket.fault);
      server_ = std::move(socket.descriptor);
      break;
    }
    case Kind::standard_output: break;  // parse() refuses it
  }
  struct stat status {};
  is_regular_ = file_ && ::fstat(file_.get(), &status) == 0 && S_ISREG(status.st_mode);
}

void Endpoint::open_file() {
  file_ = address::Descriptor(::open(address_.path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!file_) fail(std::string("cannot be opened: ") + std::strerror(errno));
}

void Endpoint::open_serial() {
  file_ = address::open_serial(address_);
  if (file_ || was_lost_) return;
  fail(errno == ENOTTY ? "is not a serial port" : std::string("cannot be opened: ") + std::strerror(errno));
}

void Endpoint::open_udp() {
  address::Socket socket = address::bind_udp(address_);
  if (!socket.descriptor) fail("port " + std::to_string(address_.port) + " cannot be opened: " + socket.fault);
  file_ = std::move(socket.descriptor);
  const int ample = 4 << 20, yes = 1;  // a second of a fast sensor; the system may give less
  ::setsockopt(file_.get(), SOL_SOCKET, SO_RCVBUF, &ample, sizeof ample);
  ::setsockopt(file_.get(), SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes);
}

/// A datagram comes with the number of those that were lost before it.
long Endpoint::receive(char* to, std::size_t size) {
  iovec part{to, size};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(std::uint32_t))];
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const auto count = ::recvmsg(file_.get(), &message, 0);
  if (count < 0) return count;
  for (cmsghdr* at = CMSG_FIRSTHDR(&message); at; at = CMSG_NXTHDR(&message, at)) {
    if (at->cmsg_level != SOL_SOCKET || at->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t lost = 0;
    std::memcpy(&lost, CMSG_DATA(at), sizeof lost);
    lost_ = lost;
  }
  return count;
}

bool Endpoint::connect() {
  next_try_ = Clock::now() + between_tries;
  file_ = address::connect_tcp(address_).descriptor;
  is_connecting_ = static_cast<bool>(file_);
  return is_connecting_;
}

int Endpoint::wait_handle() const {
  if (!file_) return server_.get();
  return is_regular_ || is_connecting_ ? -1 : file_.get();
}

Endpoint::Got Endpoint::found() { return std::exchange(was_lost_, false) ? Got::found : Got::nothing; }

Endpoint::Got Endpoint::finish_connecting() {
  pollfd handle{file_.get(), POLLOUT, 0};
  if (::poll(&handle, 1, 0) == 0) return Got::nothing;
  is_connecting_ = false;
  if (address::connect_fault(file_.get()).empty()) return found();
  file_.reset();
  return std::exchange(was_lost_, true) ? Got::nothing : Got::lost;
}

/// There is nothing to read from so far.
Endpoint::Got Endpoint::come_back() {
  if (server_) {
    file_ = address::accept_client(server_.get());
    return file_ ? found() : Got::nothing;
  }
  if (is_connecting_) return finish_connecting();
  if (Clock::now() < next_try_) return Got::nothing;
  next_try_ = Clock::now() + between_tries;
  if (address_.kind == Kind::serial) {
    open_serial();
    return file_ ? found() : Got::nothing;
  }
  if (connect() || was_lost_) return Got::nothing;
  was_lost_ = true;
  return Got::lost;
}

Endpoint::Got Endpoint::lose() {
  file_.reset();
  was_lost_ = true;
  next_try_ = Clock::now() + between_tries;
  return Got::lost;
}

Endpoint::Got Endpoint::read(std::string& to, bool ends_lines) {
  if (!file_ || is_connecting_) return come_back();
  constexpr std::size_t block = 1 << 16;
  const std::size_t before = to.size();
  to.resize(before + block);
  const bool is_udp = address_.kind == Kind::udp;
  const auto count = is_udp ? receive(to.data() + before, block) : ::read(file_.get(), to.data() + before, block);
  to.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  if (count > 0) {
    if (is_udp && ends_lines && to.back() != '\n') to += '\n';
    return Got::bytes;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return Got::nothing;
  switch (address_.kind) {
    case Kind::udp: return Got::nothing;
    case Kind::tcp_client:
    case Kind::tcp_server:
    case Kind::serial: return lose();
    default: return is_regular_ && address_.kind == Kind::file ? Got::nothing : Got::end;
  }
}

}  // namespace binnacle::line_input
