// SPDX-License-Identifier: Apache-2.0
#include "connection.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include <sys/socket.h>
#include <unistd.h>

namespace binnacle::text_output {

namespace {

bool is_full(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR || error == ENOBUFS; }

constexpr int without_waiting = MSG_NOSIGNAL | MSG_DONTWAIT;

}  // namespace

void Connection::attach(address::Descriptor descriptor) {
  descriptor_ = std::move(descriptor);
  queue_.restart();
  fault_.clear();
}

std::string Connection::send() {
  if (!fault_.empty()) return std::exchange(fault_, {});
  return way_ == Way::datagrams ? send_datagrams() : send_stream();
}

std::string Connection::send_stream() {
  while (!queue_.empty()) {
    const auto waiting = queue_.waiting();
    const ssize_t count = way_ == Way::stream_socket
                              ? ::send(descriptor_.get(), waiting.data(), waiting.size(), without_waiting)
                              : ::write(descriptor_.get(), waiting.data(), waiting.size());
    if (count < 0) return is_full(errno) ? "" : std::strerror(errno);
    queue_.sent(static_cast<std::size_t>(count));
  }
  return {};
}

/// A datagram for each line. One that the system refuses is lost, and those after it are tried.
std::string Connection::send_datagrams() {
  std::string fault;
  while (!queue_.empty()) {
    const auto line = queue_.first_line();
    const ssize_t count = ::send(descriptor_.get(), line.data(), line.size(), without_waiting);
    if (count < 0 && is_full(errno)) return fault;
    if (count < 0) {
      fault = std::strerror(errno);
      queue_.lose(line.size());
    } else {
      queue_.sent(line.size());
    }
  }
  return fault;
}

std::string Connection::take_refusal() {
  int error = 0;
  socklen_t size = sizeof error;
  if (::getsockopt(descriptor_.get(), SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error == 0) return {};
  queue_.count_as_lost();
  return std::strerror(error);
}

std::string Connection::read_and_forget() {
  std::array<char, 4096> bytes;
  for (;;) {
    const ssize_t count = ::recv(descriptor_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count == 0) return "closed by the other side";
    if (count < 0) return is_full(errno) ? "" : std::strerror(errno);
  }
}

}  // namespace binnacle::text_output
