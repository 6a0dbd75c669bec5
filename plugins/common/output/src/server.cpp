// SPDX-License-Identifier: Apache-2.0
// A TCP server: each client gets all lines from when it came.
#include <algorithm>
#include <array>
#include <list>
#include <stdexcept>

#include <netdb.h>
#include <sys/socket.h>

#include "address/socket.hpp"
#include "connection.hpp"
#include "destination.hpp"

namespace binnacle::text_output {

namespace {

constexpr std::size_t most_clients = 64;
constexpr std::size_t most_in_system = 128 * 1024;
constexpr int most_warnings = 8;  // of clients one by one

std::string name_of(int descriptor) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  std::array<char, 64> host{}, port{};
  auto* const address = reinterpret_cast<sockaddr*>(&peer);
  if (::getpeername(descriptor, address, &size) != 0 ||
      ::getnameinfo(address, size, host.data(), host.size(), port.data(), port.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return "a client";
  return "client " + std::string(host.data()) + ":" + port.data();
}

struct Client {
  std::string name;
  Connection connection;
};

class Server final : public Destination {
 public:
  Server(const address::Address& address, std::size_t buffer, Warn warn) : buffer_(buffer), warn_(std::move(warn)) {
    address::Socket socket = address::serve_tcp(address);
    if (!socket.descriptor) throw std::runtime_error(socket.fault);
    entrance_ = std::move(socket.descriptor);
  }

  void add(std::string_view line) override {
    ++lines_;
    for (Client& client : clients_) client.connection.add(line);
  }

  void serve(const pollfd* ready) override {
    const bool has_visitor = ready && (ready->revents & POLLIN) != 0;
    if (ready) ++ready;
    for (auto client = clients_.begin(); client != clients_.end();) {
      const short events = ready ? (ready++)->revents : short{0};
      std::string fault;
      if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) fault = client->connection.read_and_forget();
      if (fault.empty()) fault = client->connection.send();
      if (fault.empty()) {
        ++client;
      } else {
        report(*client, "; it left: " + fault);
        client = clients_.erase(client);
      }
    }
    if (has_visitor) take_clients();
  }

  void watch(std::vector<pollfd>& descriptors) const override {
    descriptors.push_back({entrance_.get(), POLLIN, 0});
    for (const Client& client : clients_)
      descriptors.push_back({client.connection.descriptor(),
                             static_cast<short>(POLLIN | (client.connection.waiting() > 0 ? POLLOUT : 0)), 0});
  }

  std::size_t waiting() const override {
    std::size_t bytes = 0;
    for (const Client& client : clients_) bytes += client.connection.waiting();
    return bytes;
  }

  void conclude() override {
    for (const Client& client : clients_) report(client, "");
    if (others_ > 0)
      warn_("B145",
            std::to_string(others_) + " more clients lost lines, " + std::to_string(lost_by_others_) + " in all");
    if (refused_ > 0)
      warn_("B146", std::to_string(refused_) + " clients were refused, for there were " + std::to_string(most_clients));
    if (came_ == 0 && lines_ > 0) warn_("B146", "no client came; " + std::to_string(lines_) + " lines went to nobody");
  }

 private:
  void take_clients() {
    while (auto descriptor = address::accept_client(entrance_.get())) {
      if (clients_.size() == most_clients) {
        ++refused_;
        continue;
      }
      // What the system holds for a client is bounded too: it makes room as long as the client does not read.
      const int room = static_cast<int>(std::min(buffer_, most_in_system));
      ::setsockopt(descriptor.get(), SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
      ++came_;
      const std::string name = name_of(descriptor.get());
      clients_.push_back({name, Connection(Connection::Way::stream_socket, buffer_)});
      clients_.back().connection.attach(std::move(descriptor));
    }
  }

  void report(const Client& client, const std::string& what_else) {
    const Connection& connection = client.connection;
    if (connection.lost() == 0 && (!what_else.empty() || connection.unsent() == 0)) return;
    const auto lost = what_else.empty() ? connection.unsent() : connection.lost();
    if (reported_ == most_warnings) {
      ++others_;
      lost_by_others_ += lost;
      return;
    }
    ++reported_;
    warn_("B145", client.name + " read too slowly: " + loss_text(lost, connection.lines()) + what_else);
  }

  std::size_t buffer_;
  Warn warn_;
  address::Descriptor entrance_;
  std::list<Client> clients_;
  std::int64_t lines_ = 0;
  std::int64_t came_ = 0;
  std::int64_t refused_ = 0;
  int reported_ = 0;
  std::int64_t others_ = 0;
  std::int64_t lost_by_others_ = 0;
};

}  // namespace

std::unique_ptr<Destination> make_server(const address::Address& address, std::size_t buffer, Warn warn) {
  return std::make_unique<Server>(address, buffer, std::move(warn));
}

}  // namespace binnacle::text_output
