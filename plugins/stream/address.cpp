// SPDX-License-Identifier: Apache-2.0
#include "address.hpp"

#include <charconv>
#include <string_view>

#include "binnacle/parameters.hpp"

namespace binnacle::stream {

namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw ComponentError("'" + text + "' is no address: " + why +
                           " (stdin:, file:PATH, tcp://HOST:PORT, tcp://:PORT, udp://:PORT, udp://HOST:PORT, "
                           "serial:///dev/ttyUSB0?baud=115200)",
                       "/from");
}

bool read_number(std::string_view digits, int& number) {
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() && end == digits.data() + digits.size();
}

void read_host(std::string_view rest, Address& address) {
  const auto colon = rest.rfind(':');
  if (colon == rest.npos) refuse(address.text, "the port is missing");
  address.host = rest.substr(0, colon);
  if (address.host.size() > 2 && address.host.front() == '[')
    address.host = address.host.substr(1, address.host.size() - 2);
  if (!read_number(rest.substr(colon + 1), address.port) || address.port < 1 || address.port > 65535)
    refuse(address.text, "'" + std::string(rest.substr(colon + 1)) + "' is no port from 1 to 65535");
}

void read_device(std::string_view rest, Address& address) {
  const auto query = rest.find('?');
  address.path = rest.substr(0, query);
  if (address.path.empty() || address.path.front() != '/')
    refuse(address.text, "the device has to be a path from the root; is serial:///dev/… meant?");
  if (query == rest.npos) return;
  const auto option = rest.substr(query + 1);
  if (!option.starts_with("baud=") || !read_number(option.substr(5), address.baud) || address.baud < 1)
    refuse(address.text, "after '?' stands baud=NUMBER");
}

}  // namespace

Address parse_address(const std::string& text) {
  Address address;
  address.text = text;
  const std::string_view all(text);
  const auto after = [&](std::string_view scheme) { return all.substr(scheme.size()); };
  if (all == "stdin:") return address;
  const std::string name(all.substr(all.rfind('/') + 1));  // a bare name stands beside the config by now
  if (name == "stdin" || name == "-") refuse(name, "did you mean 'stdin:'?");
  if (all.starts_with("file:")) {
    address.scheme = Address::Scheme::file;
    address.path = all.starts_with("file://") ? after("file://") : after("file:");
    if (address.path.empty()) refuse(text, "the path is missing");
  } else if (all.starts_with("tcp://")) {
    address.scheme = Address::Scheme::tcp;
    read_host(after("tcp://"), address);
  } else if (all.starts_with("udp://")) {
    address.scheme = Address::Scheme::udp;
    read_host(after("udp://"), address);
  } else if (all.starts_with("serial://")) {
    address.scheme = Address::Scheme::serial;
    read_device(after("serial://"), address);
  } else if (all.find(':') == all.npos) {
    refuse(name, "did you mean 'file:" + name + "'?");
  } else {
    refuse(text, "'" + std::string(all.substr(0, all.find(':'))) + "' is none of its kinds");
  }
  return address;
}

}  // namespace binnacle::stream
