// SPDX-License-Identifier: Apache-2.0
#include "viewer.hpp"

#include <chrono>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>

#include "server.hpp"

namespace binnacle::live {

namespace {

/// For one event; a page that takes longer is gone.
constexpr std::chrono::seconds viewer_timeout{30};

/// Of the system's, for what is on its way; more would let a slow page lag behind [bytes].
constexpr int buffer = 256 * 1024;

/// What comes behind it ends with the connection.
constexpr const char* head =
    "HTTP/1.1 200 OK\r\n"
    "Content-Type: text/event-stream\r\n"
    "Cache-Control: no-store\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Connection: close\r\n"
    "\r\n"
    "retry: 1000\n\n";

}  // namespace

Viewer::Viewer(Server& server, asio::ip::tcp::socket socket, std::shared_ptr<const void> ticket)
    : server_(server), socket_(std::move(socket)), ticket_(std::move(ticket)), patience_(socket_.get_executor()) {}

void Viewer::start() {
  boost::system::error_code ignored;
  socket_.set_option(asio::socket_base::send_buffer_size(buffer), ignored);
  watch_for_end();
  write(std::make_shared<const std::string>(head));
}

void Viewer::offer(std::shared_ptr<const std::string> event) {
  if (under_way_)
    next_ = std::move(event);
  else
    write(std::move(event));
}

void Viewer::leave() {
  is_leaving_ = true;
  if (!under_way_) end();
}

void Viewer::write(std::shared_ptr<const std::string> text) {
  under_way_ = std::move(text);
  patience_.expires_after(viewer_timeout);
  patience_.async_wait([self = shared_from_this()](const auto& error) {
    if (!error) self->end();
  });
  asio::async_write(socket_, asio::buffer(*under_way_),
                    [self = shared_from_this()](const auto& error, std::size_t) { self->written(!error); });
}

void Viewer::written(bool is_well) {
  patience_.cancel();
  under_way_.reset();
  if (!is_well) return end();
  if (next_) return write(std::exchange(next_, nullptr));
  if (is_leaving_) end();
}

/// A browser says nothing more; what is read is the end of the connection.
void Viewer::watch_for_end() {
  socket_.async_read_some(asio::buffer(ignored_), [self = shared_from_this()](const auto& error, std::size_t) {
    if (error)
      self->end();
    else
      self->watch_for_end();
  });
}

void Viewer::end() {
  if (!socket_.is_open()) return;
  boost::system::error_code ignored;
  socket_.close(ignored);
  patience_.cancel();
  const auto self = shared_from_this();
  server_.remove_viewer(*this);
}

}  // namespace binnacle::live
