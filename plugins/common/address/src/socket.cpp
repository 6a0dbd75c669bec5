// SPDX-License-Identifier: Apache-2.0
#include "address/socket.hpp"

#include <cerrno>
#include <cstring>
#include <memory>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace binnacle::address {

namespace {

constexpr int backlog = 16;

/// A socket of the address on which `action` succeeds, which returns 0 then, as the calls of the system do.
template <class Action>
Socket make(const Address& address, int type, int flags, const char* what, Action&& action) {
  addrinfo hints{};
  hints.ai_socktype = type;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
      error != 0)
    return {{}, "host '" + address.host + "' cannot be found: " + ::gai_strerror(error)};
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(found, ::freeaddrinfo);
  std::string fault;
  for (const addrinfo* each = found; each; each = each->ai_next) {
    Descriptor socket(::socket(each->ai_family, type | SOCK_NONBLOCK | SOCK_CLOEXEC, each->ai_protocol));
    if (socket && action(socket.get(), each->ai_addr, each->ai_addrlen) == 0) return {std::move(socket), ""};
    fault = std::string(what) + ": " + std::strerror(errno);
  }
  return {{}, fault};
}

void set(int socket, int level, int option) {
  const int on = 1;
  ::setsockopt(socket, level, option, &on, sizeof on);
}

}  // namespace

Socket connect_tcp(const Address& address) {
  return make(address, SOCK_STREAM, 0, "cannot connect", [](int socket, const sockaddr* to, socklen_t size) {
    set(socket, IPPROTO_TCP, TCP_NODELAY);
    const int result = ::connect(socket, to, size);
    return result != 0 && errno == EINPROGRESS ? 0 : result;
  });
}

std::string connect_fault(int descriptor) {
  int error = 0;
  socklen_t size = sizeof error;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = errno;
  return error == 0 ? "" : std::string("cannot connect: ") + std::strerror(error);
}

Socket serve_tcp(const Address& address) {
  return make(address, SOCK_STREAM, AI_PASSIVE, "cannot be served", [](int socket, const sockaddr* at, socklen_t size) {
    set(socket, SOL_SOCKET, SO_REUSEADDR);
    return ::bind(socket, at, size) != 0 ? -1 : ::listen(socket, backlog);
  });
}

Descriptor accept_client(int server) {
  Descriptor client(::accept4(server, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (client) set(client.get(), IPPROTO_TCP, TCP_NODELAY);
  return client;
}

Socket bind_udp(const Address& address) {
  return make(address, SOCK_DGRAM, AI_PASSIVE, "cannot receive",
              [](int socket, const sockaddr* at, socklen_t size) { return ::bind(socket, at, size); });
}

Socket connect_udp(const Address& address) {
  return make(address, SOCK_DGRAM, 0, "cannot send",
              [](int socket, const sockaddr* to, socklen_t size) { return ::connect(socket, to, size); });
}

}  // namespace binnacle::address
