// SPDX-License-Identifier: Apache-2.0
#include "paced_run.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace binnacle::test {

namespace {

std::vector<std::string> arguments(const Workbench& bench, const std::vector<std::string>& more) {
  bench.write("open", "0");
  bench.write("paced.json", R"({
  "binnacle": 1,
  "extends": ")" BINNACLE_TEST_PROJECT R"(/configs/quickstart.json",
  "plugins": [")" VALVE_PLUGIN R"("],
  "sinks": { "valve": { "type": "valve", "input": "drive.imu", "path": "open" } }
}
)");
  std::vector<std::string> all{"run", "paced.json", "--page", "0"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

int port_in(const std::string& text) {
  const std::string before = "page: http://127.0.0.1:";
  const auto at = text.find(before);
  return at == std::string::npos || text.find('\n', at) == std::string::npos
             ? 0
             : std::stoi(text.substr(at + before.size()));
}

}  // namespace

PacedRun::PacedRun(const std::vector<std::string>& more_arguments)
    : command_(bench_, arguments(bench_, more_arguments)) {
  while (port_ == 0) {
    const bool is_running = command_.is_running();
    if (std::filesystem::exists(bench_.beside("stderr"))) port_ = port_in(read_file(bench_.beside("stderr")));
    if (!is_running && port_ == 0) throw std::runtime_error("no page: " + command_.wait().err);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void PacedRun::open_until(double t) const {
  bench_.write("next", std::to_string(t));
  std::filesystem::rename(bench_.path("next"), bench_.path("open"));
}

void PacedRun::wait_until_held(double t) {
  const std::string file = bench_.path("open.held");
  for (double held = -1; held != t; std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
    if (!command_.is_running()) throw std::runtime_error("the run has ended");
    std::ifstream(file) >> held;
  }
}

Client::Client(int port, int receive_buffer) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  const timeval timeout{30, 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  if (receive_buffer > 0) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("no connection");
}

Client::~Client() { ::close(socket_); }

void Client::send(const std::string& text) const {
  for (std::size_t at = 0; at < text.size();) {
    const auto count = ::send(socket_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
    if (count <= 0) return;  // the server takes no more
    at += static_cast<std::size_t>(count);
  }
}

std::string Client::rest() const {
  std::string text = received_;
  char buffer[65536];
  for (;;) {
    const auto count = ::recv(socket_, buffer, sizeof buffer, 0);
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) throw std::runtime_error("the server never closed");
    if (count <= 0) return text;
    text.append(buffer, static_cast<std::size_t>(count));
  }
}

std::string Client::until(const std::string& mark) {
  char buffer[65536];
  std::size_t searched = 0;
  for (;;) {
    const auto at = received_.find(mark, searched);
    if (at != std::string::npos) {
      const std::string text = received_.substr(0, at + mark.size());
      received_.erase(0, at + mark.size());
      return text;
    }
    searched = received_.size() < mark.size() ? 0 : received_.size() - mark.size();
    const auto count = ::recv(socket_, buffer, sizeof buffer, 0);
    if (count <= 0) throw std::runtime_error("no '" + mark + "' came");
    received_.append(buffer, static_cast<std::size_t>(count));
  }
}

std::string answer(int port, const std::string& request) {
  const Client client(port);
  client.send(request);
  return client.rest();
}

}  // namespace binnacle::test
