// SPDX-License-Identifier: Apache-2.0
// Sockets of an address; none blocks.
#pragma once

#include <string>

#include "address/address.hpp"
#include "address/descriptor.hpp"

namespace binnacle::address {

/// A socket, or why there is none.
struct Socket {
  Descriptor descriptor;
  std::string fault;
};

/// Begins to connect (tcp_client): once it can be written to, connect_fault() has the outcome.
Socket connect_tcp(const Address& address);
/// "": connected.
std::string connect_fault(int descriptor);
/// Serves (tcp_server).
Socket serve_tcp(const Address& address);
/// Of a server socket; invalid where nobody waits.
Descriptor accept_client(int server);
/// Receives (udp).
Socket bind_udp(const Address& address);
/// Sends by plain write() (udp).
Socket connect_udp(const Address& address);

}  // namespace binnacle::address
