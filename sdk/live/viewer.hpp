// SPDX-License-Identifier: Apache-2.0
// Viewer: a page that is open, and takes events.
#pragma once

#include <array>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

namespace binnacle::live {

namespace asio = boost::asio;

class Server;

/// One event is under way, and no more than one waits: the newest.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(Server& server, asio::ip::tcp::socket socket, std::shared_ptr<const void> ticket);

  void start();
  void offer(std::shared_ptr<const std::string> event);
  bool is_idle() const { return !under_way_; }
  /// When it has got what it was offered.
  void leave();

 private:
  void write(std::shared_ptr<const std::string> text);
  void written(bool is_well);
  void watch_for_end();
  void end();

  Server& server_;
  asio::ip::tcp::socket socket_;
  std::shared_ptr<const void> ticket_;
  asio::steady_timer patience_;
  std::shared_ptr<const std::string> under_way_, next_;
  std::array<char, 512> ignored_;
  bool is_leaving_ = false;
};

}  // namespace binnacle::live
