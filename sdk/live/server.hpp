// SPDX-License-Identifier: Apache-2.0
// Server: one page and its events over HTTP, in a thread of its own.
#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

namespace binnacle::live {

namespace asio = boost::asio;

class Viewer;

class Server {
 public:
  static constexpr int most_connections = 32;
  static constexpr std::size_t most_viewers = 8;

  /// Makes one line of text, in the server's thread.
  using Text = std::function<std::string()>;

  /// Takes connections at once. Throws AddressError.
  Server(const asio::ip::tcp::endpoint& endpoint, std::string page);
  /// After publish_last(), viewers have a second to take what is left.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::string url() const;

  // ---- for the thread of the run: none of these waits

  /// Whether somebody looks.
  bool is_watched() const noexcept { return is_watched_.load(std::memory_order_relaxed); }
  /// Whether something new is wanted: once per question.
  bool asks() noexcept { return asks_.load(std::memory_order_relaxed) && asks_.exchange(false); }
  void publish(Text text);
  /// No more comes.
  void publish_last(Text text);

  // ---- for the connections, in the server's thread

  const std::string& page() const { return page_; }
  unsigned short port() const { return endpoint_.port(); }
  bool has_room_for_viewer() const { return viewers_.size() < most_viewers; }
  /// The ticket of its connection goes over to the viewer.
  void add_viewer(asio::ip::tcp::socket socket, std::shared_ptr<const void> ticket);
  void remove_viewer(const Viewer& viewer);

 private:
  void accept();
  void ask();
  void show(std::string text);
  void rest();

  std::string page_;
  asio::io_context context_{1};
  asio::ip::tcp::acceptor acceptor_;
  asio::ip::tcp::endpoint endpoint_;
  asio::steady_timer pause_, last_wait_;
  std::shared_ptr<int> tickets_ = std::make_shared<int>();  // every connection holds one
  std::list<std::shared_ptr<Viewer>> viewers_;
  std::shared_ptr<const std::string> newest_;  // event
  bool is_asking_ = false, is_over_ = false;
  std::atomic<bool> is_watched_{false}, asks_{false};
  std::thread thread_;
};

}  // namespace binnacle::live
