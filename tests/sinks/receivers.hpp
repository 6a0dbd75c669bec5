// SPDX-License-Identifier: Apache-2.0
// What live output is sent to in tests: clients, datagrams, a pseudo-terminal, a folder.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "binnacle/source.hpp"

namespace binnacle::receivers {

struct Warning {
  std::string code, file, message;
};

class Warnings : public Reporter {
 public:
  void warn(const std::string& code, const std::string& file, int /*line*/, const std::string& message) override {
    all.push_back({code, file, message});
  }
  /// The messages of a code.
  std::vector<std::string> of(const std::string& code) const {
    std::vector<std::string> found;
    for (const auto& warning : all)
      if (warning.code == code) found.push_back(warning.message);
    return found;
  }
  std::vector<Warning> all;
};

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "binnacle_sinks_").string() + std::string(6, 'X');
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// A descriptor that is read to see what came.
class Reading {
 public:
  explicit Reading(int fd = -1) : fd_(fd) {}
  Reading(Reading&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~Reading() { close(); }
  int fd() const { return fd_; }
  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }
  /// What comes until the end, or until nothing has come for so long.
  std::string all(std::chrono::milliseconds silence = std::chrono::seconds(3)) const {
    std::string text;
    char bytes[65536];
    for (;;) {
      pollfd handle{fd_, POLLIN, 0};
      if (::poll(&handle, 1, static_cast<int>(silence.count())) <= 0) return text;
      const auto count = ::read(fd_, bytes, sizeof bytes);
      if (count <= 0) return text;
      text.append(bytes, static_cast<std::size_t>(count));
    }
  }
  /// What comes until `text` has so many bytes, or for three seconds nothing.
  std::string bytes(std::size_t count) const {
    std::string text;
    while (text.size() < count) {
      pollfd handle{fd_, POLLIN, 0};
      if (::poll(&handle, 1, 3000) <= 0) break;
      std::string piece(count - text.size(), '\0');
      const auto got = ::read(fd_, piece.data(), piece.size());
      if (got <= 0) break;
      text.append(piece, 0, static_cast<std::size_t>(got));
    }
    return text;
  }

 private:
  int fd_;
};

inline sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

inline int port_of(int fd) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

/// A socket on a port of loopback, 0 for any that is free.
inline int bound(int type, int port = 0) {
  const int fd = ::socket(AF_INET, type | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const auto address = loopback(port);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("port " + std::to_string(port) + " cannot be bound");
  return fd;
}

/// One that was free a moment ago.
inline int free_port() {
  const Reading socket(bound(SOCK_STREAM));
  return port_of(socket.fd());
}

/// A TCP client of loopback; tries for three seconds. `room`: of its receive buffer, 0 for the system's.
inline Reading connected(int port, int room = 0) {
  for (int i = 0; i < 300; ++i) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (room > 0) ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    const auto address = loopback(port);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return Reading(fd);
    ::close(fd);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error("nobody accepts on port " + std::to_string(port));
}

/// The side of a pseudo-terminal that a program reads which has opened the other for its device.
class Terminal {
 public:
  Terminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (master_.fd() < 0 || ::grantpt(master_.fd()) != 0 || ::unlockpt(master_.fd()) != 0)
      throw std::runtime_error("no pseudo-terminal");
    device_ = ::ptsname(master_.fd());
    termios settings{};
    ::tcgetattr(master_.fd(), &settings);
    ::cfmakeraw(&settings);
    ::tcsetattr(master_.fd(), TCSANOW, &settings);
  }
  const std::string& device() const { return device_; }
  Reading& master() { return master_; }

 private:
  Reading master_;
  std::string device_;
};

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

}  // namespace binnacle::receivers
