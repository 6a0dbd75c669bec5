// SPDX-License-Identifier: Apache-2.0
#include "endpoint.hpp"

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include "binnacle/parameters.hpp"

namespace binnacle::stream {

namespace {

constexpr std::chrono::seconds between_tries{1};

speed_t speed_of(int baud) {
  constexpr std::pair<int, speed_t> known[] = {{4800, B4800},     {9600, B9600},     {19200, B19200},
                                               {38400, B38400},   {57600, B57600},   {115200, B115200},
                                               {230400, B230400}, {460800, B460800}, {921600, B921600}};
  for (const auto& [number, speed] : known)
    if (number == baud) return speed;
  return B0;
}

struct FreeAddresses {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};
using Addresses = std::unique_ptr<addrinfo, FreeAddresses>;

Addresses resolve(const Address& address, std::string& why) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = address.scheme == Address::Scheme::udp ? SOCK_DGRAM : SOCK_STREAM;
  const std::string host = address.host.empty() ? "127.0.0.1" : address.host;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (error != 0) why = ::gai_strerror(error);
  return Addresses(found);
}

int make_socket(const addrinfo& of) {
  return ::socket(of.ai_family, of.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, of.ai_protocol);
}

}  // namespace

Endpoint::~Endpoint() {
  for (const int file : {file_, listener_})
    if (file > STDIN_FILENO) ::close(file);
}

void Endpoint::fail(const std::string& why, const char* code) const {
  throw ComponentError::in_data(why, address_.text, 0, code);
}

void Endpoint::open() {
  using enum Address::Scheme;
  switch (address_.scheme) {
    case standard_input:
      file_ = STDIN_FILENO;
      ::fcntl(file_, F_SETFL, ::fcntl(file_, F_GETFL) | O_NONBLOCK);
      break;
    case file: open_file(); break;
    case serial: open_serial(); break;
    case tcp:
    case udp: open_socket(); break;
  }
  struct stat status {};
  is_regular_ = file_ >= 0 && ::fstat(file_, &status) == 0 && S_ISREG(status.st_mode);
}

void Endpoint::open_file() {
  file_ = ::open(address_.path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) fail(std::string("cannot be opened: ") + std::strerror(errno), "B060");
}

void Endpoint::open_serial() {
  file_ = ::open(address_.path.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) {
    if (was_lost_) return;
    fail(std::string("cannot be opened: ") + std::strerror(errno), "B060");
  }
  termios line{};
  if (::tcgetattr(file_, &line) != 0) {
    if (!was_lost_) fail("is no serial port", "B060");
    ::close(std::exchange(file_, -1));
    return;
  }
  ::cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  const speed_t speed = speed_of(address_.baud);
  if (speed == B0) fail(std::to_string(address_.baud) + " is no usual baud rate", "B060");
  ::cfsetispeed(&line, speed);
  ::cfsetospeed(&line, speed);
  ::tcsetattr(file_, TCSANOW, &line);
}

/// UDP, and a TCP server, are bound at once; a TCP client connects when it can.
void Endpoint::open_socket() {
  std::string why;
  const Addresses addresses = resolve(address_, why);
  if (!addresses) fail("'" + address_.host + "' cannot be found: " + why, "B060");
  const bool is_client = address_.scheme == Address::Scheme::tcp && !address_.host.empty();
  if (is_client) {
    connect();
    return;
  }
  const int bound = make_socket(*addresses);
  const int yes = 1;
  if (address_.scheme == Address::Scheme::tcp) ::setsockopt(bound, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const bool is_bound = bound >= 0 && ::bind(bound, addresses->ai_addr, addresses->ai_addrlen) == 0;
  if (!is_bound || (address_.scheme == Address::Scheme::tcp && ::listen(bound, 1) != 0)) {
    const int reason = errno;
    if (bound >= 0) ::close(bound);
    fail("port " + std::to_string(address_.port) + " cannot be opened: " + std::strerror(reason), "B060");
  }
  (address_.scheme == Address::Scheme::tcp ? listener_ : file_) = bound;
  if (address_.scheme == Address::Scheme::tcp) return;
  const int ample = 4 << 20;  // a second of a fast sensor; the system may give less
  ::setsockopt(bound, SOL_SOCKET, SO_RCVBUF, &ample, sizeof ample);
  ::setsockopt(bound, SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes);
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
  const auto count = ::recvmsg(file_, &message, 0);
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
  std::string why;
  const Addresses addresses = resolve(address_, why);
  if (!addresses) return false;
  file_ = make_socket(*addresses);
  is_connecting_ = file_ >= 0 && ::connect(file_, addresses->ai_addr, addresses->ai_addrlen) != 0;
  if (is_connecting_ && errno != EINPROGRESS) {
    is_connecting_ = false;
    ::close(std::exchange(file_, -1));
  }
  return file_ >= 0;
}

bool Endpoint::accept() {
  file_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  return file_ >= 0;
}

int Endpoint::wait_handle() const {
  if (file_ < 0) return listener_;
  return is_regular_ || is_connecting_ ? -1 : file_;
}

/// There is nothing to read from so far.
Endpoint::Got Endpoint::come_back() {
  if (listener_ >= 0) return accept() ? std::exchange(was_lost_, false) ? Got::found : Got::nothing : Got::nothing;
  if (is_connecting_) {
    pollfd handle{file_, POLLOUT, 0};
    if (::poll(&handle, 1, 0) == 0) return Got::nothing;
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(file_, SOL_SOCKET, SO_ERROR, &error, &size);
    is_connecting_ = false;
    if (error == 0) return std::exchange(was_lost_, false) ? Got::found : Got::nothing;
    ::close(std::exchange(file_, -1));
    return std::exchange(was_lost_, true) ? Got::nothing : Got::lost;
  }
  if (Clock::now() < next_try_) return Got::nothing;
  next_try_ = Clock::now() + between_tries;
  if (address_.scheme == Address::Scheme::serial) {
    open_serial();
    return file_ >= 0 && std::exchange(was_lost_, false) ? Got::found : Got::nothing;
  }
  if (connect() && !is_connecting_) return std::exchange(was_lost_, false) ? Got::found : Got::nothing;
  if (is_connecting_ || was_lost_) return Got::nothing;
  was_lost_ = true;
  return Got::lost;
}

Endpoint::Got Endpoint::lose() {
  ::close(std::exchange(file_, -1));
  was_lost_ = true;
  next_try_ = Clock::now() + between_tries;
  return Got::lost;
}

Endpoint::Got Endpoint::read(std::string& to) {
  if (file_ < 0 || is_connecting_) return come_back();
  constexpr std::size_t block = 1 << 16;
  const std::size_t before = to.size();
  to.resize(before + block);
  const bool is_udp = address_.scheme == Address::Scheme::udp;
  const auto count = is_udp ? receive(to.data() + before, block) : ::read(file_, to.data() + before, block);
  to.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  const bool comes_back = address_.scheme == Address::Scheme::tcp || address_.scheme == Address::Scheme::serial;
  if (count > 0) {
    if (is_udp && to.back() != '\n') to += '\n';
    return Got::bytes;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return Got::nothing;
  if (is_udp) return Got::nothing;
  if (comes_back) return lose();
  return is_regular_ && address_.scheme == Address::Scheme::file ? Got::nothing : Got::end;
}

}  // namespace binnacle::stream
