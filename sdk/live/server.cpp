// SPDX-License-Identifier: Apache-2.0
#include "server.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <boost/asio/post.hpp>

#include "live/run_page.hpp"
#include "results/thread_without_signals.hpp"
#include "viewer.hpp"
#include "visit.hpp"

namespace binnacle::live {

namespace {

using namespace std::chrono_literals;
using asio::ip::tcp;

/// Between two events; a page that is slower gets fewer.
constexpr auto event_interval = 500ms;
constexpr auto last_patience = 1s;

std::string text_of(const tcp::endpoint& endpoint) {
  const std::string host = endpoint.address().to_string();
  return (endpoint.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(endpoint.port());
}

[[noreturn]] void refuse(const tcp::endpoint& endpoint, const boost::system::error_code& error) {
  throw AddressError("--page: the page cannot be served at " + text_of(endpoint) + ": " + error.message() +
                     "; expected an address of this machine and a free port, or port 0 for any free one");
}

}  // namespace

Server::Server(const tcp::endpoint& endpoint, std::string page)
    : page_(std::move(page)), acceptor_(context_), pause_(context_), last_wait_(context_) {
  boost::system::error_code error;
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(tcp::acceptor::max_listen_connections, error);
  if (error) refuse(endpoint, error);
  endpoint_ = acceptor_.local_endpoint();
  accept();
  thread_ = results::thread_without_signals([this] {
    for (bool is_done = false; !is_done;) try {
        context_.run();
        is_done = true;
      } catch (const std::exception&) {  // of one event; the next may be made
      }
  });
}

Server::~Server() {
  asio::post(context_, [this] {
    if (!is_over_ || viewers_.empty()) return context_.stop();
    last_wait_.expires_after(last_patience);
    last_wait_.async_wait([this](const auto&) { context_.stop(); });
  });
  thread_.join();
}

std::string Server::url() const { return "http://" + text_of(endpoint_) + "/"; }

void Server::publish(Text text) {
  asio::post(context_, [this, text = std::move(text)] { show(text()); });
}

void Server::publish_last(Text text) {
  is_watched_ = false;
  asio::post(context_, [this, text = std::move(text)] {
    is_over_ = true;
    acceptor_.close();
    pause_.cancel();
    if (!viewers_.empty()) show(text());
    rest();
  });
}

void Server::add_viewer(tcp::socket socket, std::shared_ptr<const void> ticket) {
  viewers_.push_back(std::make_shared<Viewer>(*this, std::move(socket), std::move(ticket)));
  viewers_.back()->start();
  if (newest_) viewers_.back()->offer(newest_);
  if (is_over_) return rest();
  is_watched_ = true;
  if (!std::exchange(is_asking_, true)) ask();
}

void Server::remove_viewer(const Viewer& viewer) {
  viewers_.remove_if([&](const auto& one) { return one.get() == &viewer; });
  if (!viewers_.empty()) return;
  is_watched_ = false;
  if (is_over_) context_.stop();
}

void Server::accept() {
  acceptor_.async_accept([this](const boost::system::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !acceptor_.is_open()) return;
    const bool has_room = tickets_.use_count() - 1 < most_connections;
    if (!error && has_room) std::make_shared<Visit>(*this, std::move(socket), tickets_)->start();
    accept();  // beyond that, the socket is closed at once
  });
}

/// For as long as somebody looks, where somebody could take it.
void Server::ask() {
  if (viewers_.empty() || is_over_) {
    is_asking_ = false;
    return;
  }
  if (std::ranges::any_of(viewers_, [](const auto& viewer) { return viewer->is_idle(); })) asks_ = true;
  pause_.expires_after(event_interval);
  pause_.async_wait([this](const auto&) { ask(); });
}

void Server::show(std::string text) {
  newest_ = std::make_shared<const std::string>("data: " + std::move(text) + "\n\n");
  for (const auto& viewer : viewers_) viewer->offer(newest_);
}

/// Viewers leave when they have got all.
void Server::rest() {
  const auto viewers = viewers_;  // some leave at once
  for (const auto& viewer : viewers) viewer->leave();
}

}  // namespace binnacle::live
