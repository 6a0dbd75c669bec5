// SPDX-License-Identifier: Apache-2.0
#include "address.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "live/run_page.hpp"

namespace binnacle::live {

namespace {

namespace ip = boost::asio::ip;

struct Parts {
  std::string_view host, port;
};

/// At the last colon that is not inside of brackets; without one, all of it is the port.
Parts parts_of(std::string_view text) {
  const auto bracket = text.rfind(']'), colon = text.rfind(':');
  if (colon == std::string_view::npos || (bracket != std::string_view::npos && colon < bracket)) return {"", text};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

std::optional<unsigned short> port_of(std::string_view text) {
  unsigned short port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return port;
}

bool is_localhost(std::string_view host) {
  return std::equal(host.begin(), host.end(), std::begin("localhost"), std::end("localhost") - 1,
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

/// A number, an IPv6 one in brackets.
std::optional<ip::address> number_of(std::string_view host) {
  const bool is_bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  boost::system::error_code error;
  const auto address = ip::make_address(std::string(is_bracketed ? host.substr(1, host.size() - 2) : host), error);
  if (error || address.is_v6() != is_bracketed) return std::nullopt;
  return address;
}

[[noreturn]] void refuse(std::string_view text, const std::string& found) {
  throw AddressError("--page: '" + std::string(text) + "': " + found +
                     "; expected [HOST:]PORT, as 127.0.0.1:8080 or 8080: HOST is an address in numbers, an IPv6 one in "
                     "brackets, or localhost; PORT is 0 (any free one) to 65535");
}

}  // namespace

ip::tcp::endpoint endpoint_of(std::string_view text) {
  const auto [host, port_text] = parts_of(text);
  const auto port = port_of(port_text);
  if (!port) refuse(text, "'" + std::string(port_text) + "' is not a port");
  if (host.empty() || is_localhost(host)) return {ip::address_v4::loopback(), *port};
  const auto address = number_of(host);
  if (!address) refuse(text, "'" + std::string(host) + "' is not an address");
  return {*address, *port};
}

bool is_own_host(std::string_view host, unsigned short port) {
  constexpr unsigned short usual_port = 80;  // which a browser leaves out
  const auto colon = host.rfind(':');
  const bool has_port = colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos;
  const auto asked = has_port ? port_of(host.substr(colon + 1)) : usual_port;
  const std::string_view name = has_port ? host.substr(0, colon) : host;
  return asked == port && (is_localhost(name) || number_of(name).has_value());
}

}  // namespace binnacle::live
