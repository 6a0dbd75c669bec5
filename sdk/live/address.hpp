// SPDX-License-Identifier: Apache-2.0
// Where a page is served, and by which names a browser may ask for it.
#pragma once

#include <string_view>

#include <boost/asio/ip/tcp.hpp>

namespace binnacle::live {

/// "127.0.0.1:8080", "[::1]:8080", "localhost:8080"; ":8080" and "8080" are of the loopback. Throws AddressError.
boost::asio::ip::tcp::endpoint endpoint_of(std::string_view text);

/// Whether a request's Host names this machine by number, or as localhost, and the port. Another name may be one that
/// somebody else made to point here (DNS rebinding).
bool is_own_host(std::string_view host, unsigned short port);

}  // namespace binnacle::live
