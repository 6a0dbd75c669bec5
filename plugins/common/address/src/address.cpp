// SPDX-License-Identifier: Apache-2.0
#include "address/address.hpp"

#include <cctype>
#include <charconv>
#include <string_view>

#include "address/serial.hpp"
#include "binnacle/parameters.hpp"

namespace binnacle::address {

namespace {

std::string forms(Direction direction) {
  return std::string("an address is ") + (direction == Direction::input ? "stdin:" : "stdout:") +
         ", file:PATH, tcp://HOST:PORT, tcp://:PORT (a server), udp://HOST:PORT, udp://:PORT or "
         "serial:///dev/NAME?baud=115200";
}

class Parser {
 public:
  Parser(const std::string& text, Direction direction, const std::string& pointer)
      : text_(text), direction_(direction), pointer_(pointer) {
    address_.text = text;
  }

  Address parse() {
    if (text_ == "stdin:" || text_ == "stdout:") return standard();
    if (rest_after("file:")) return file();
    if (rest_after("tcp://")) return tcp();
    if (rest_after("udp://")) return udp();
    if (rest_after("serial://")) return serial();
    refuse_scheme();
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw ComponentError("'" + text_ + "': " + why, pointer_); }

  [[noreturn]] void refuse_scheme() const {
    const auto meant = [&](const std::string& what) { refuse("did you mean '" + what + "'? " + forms(direction_)); };
    const std::string name = text_.substr(text_.rfind('/') + 1);  // a bare name stands beside the config by now
    if (name == "-" || name == "stdin" || name == "stdout")
      meant(direction_ == Direction::input ? "stdin:" : "stdout:");
    if (text_.starts_with("/dev/")) meant("serial://" + text_);
    if (text_.starts_with("serial:/dev/")) meant("serial://" + text_.substr(7));
    for (const char* scheme : {"tcp:", "udp:"})
      if (text_.starts_with(scheme)) meant(scheme + std::string("//") + text_.substr(4));
    std::string small;
    for (const char c : text_.substr(0, text_.find(':')))
      small += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char* scheme : {"stdin", "stdout", "file", "tcp", "udp", "serial"})
      if (text_.find(':') != text_.npos && small == scheme && !text_.starts_with(scheme))
        meant(small + text_.substr(small.size()));
    if (!name.empty() && text_.find(':') == text_.npos) meant("file:" + name);
    refuse(forms(direction_));
  }

  bool rest_after(std::string_view scheme) {
    if (!text_.starts_with(scheme)) return false;
    rest_ = std::string_view(text_).substr(scheme.size());
    return true;
  }

  Address standard() {
    const bool is_input = text_ == "stdin:";
    if (is_input != (direction_ == Direction::input))
      refuse(is_input ? "it is not writable; did you mean 'stdout:'?" : "it is not readable; did you mean 'stdin:'?");
    address_.kind = is_input ? Kind::standard_input : Kind::standard_output;
    return address_;
  }

  Address file() {
    if (rest_.starts_with("//")) rest_.remove_prefix(2);
    if (rest_.empty()) refuse("no file is named; expected file:PATH");
    address_.kind = Kind::file;
    address_.path = rest_;
    return address_;
  }

  Address tcp() {
    const std::string_view query = take_query();
    if (!query.empty() && query != "server")
      refuse("found '?" + std::string(query) + "'; the one option of tcp:// is ?server");
    address_.kind = take_host_and_port() && query.empty() ? Kind::tcp_client : Kind::tcp_server;
    return address_;
  }

  Address udp() {
    const std::string_view query = take_query();
    if (!query.empty()) refuse("found '?" + std::string(query) + "'; udp:// has no options");
    take_host_and_port();
    address_.kind = Kind::udp;
    return address_;
  }

  Address serial() {
    const std::string_view query = take_query();
    if (!rest_.starts_with("/"))
      refuse("a device is named by its whole path, with three slashes: 'serial:///dev/" + std::string(rest_) + "'");
    address_.kind = Kind::serial;
    address_.path = rest_;
    address_.baud = 115200;
    if (query.empty()) return address_;
    if (!query.starts_with("baud="))
      refuse("found '?" + std::string(query) + "'; the one option of serial:// is ?baud=NUMBER");
    const std::string_view rate = query.substr(5);
    if (!whole_number(rate, address_.baud) || !is_baud(address_.baud))
      refuse(
          "'" + std::string(rate) +
          "' is not a rate of a serial line; usual ones are 4800, 9600, 38400, 57600, 115200, 230400, 460800, 921600");
    return address_;
  }

  /// What follows a '?'.
  std::string_view take_query() {
    const auto at = rest_.find('?');
    if (at == rest_.npos) return {};
    const std::string_view query = rest_.substr(at + 1);
    rest_ = rest_.substr(0, at);
    return query;
  }

  /// Whether a host was given.
  bool take_host_and_port() {
    if (rest_.ends_with('/')) rest_.remove_suffix(1);
    const auto colon = rest_.rfind(':');
    const bool is_bracketed = rest_.starts_with('[');
    if (colon == rest_.npos || (is_bracketed && colon < rest_.find(']')))
      refuse("no port is given; expected " + text_.substr(0, 6) + (rest_.empty() ? "HOST" : std::string(rest_)) +
             ":PORT");
    const std::string_view port = rest_.substr(colon + 1);
    if (!whole_number(port, address_.port) || address_.port < 1 || address_.port > 65535)
      refuse("'" + std::string(port) + "' is not a port; a port is a number from 1 to 65535");
    std::string_view host = rest_.substr(0, colon);
    if (is_bracketed && host.ends_with(']'))
      host = host.substr(1, host.size() - 2);
    else if (host.find(':') != host.npos)
      refuse("an IPv6 address stands in brackets: '" + text_.substr(0, 6) + "[" + std::string(host) +
             "]:" + std::string(port) + "'");
    if (host == "*") refuse("'*' is not a host; all interfaces are 0.0.0.0, or [::]");
    address_.host = host.empty() ? "127.0.0.1" : host;
    return !host.empty();
  }

  static bool whole_number(std::string_view digits, int& value) {
    const auto [rest, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() && rest == digits.data() + digits.size();
  }

  const std::string& text_;
  Direction direction_;
  const std::string& pointer_;
  Address address_;
  std::string_view rest_;
};

}  // namespace

Address parse(const std::string& text, Direction direction, const std::string& pointer) {
  return Parser(text, direction, pointer).parse();
}

}  // namespace binnacle::address
