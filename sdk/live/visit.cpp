// SPDX-License-Identifier: Apache-2.0
#include "visit.hpp"

#include <chrono>
#include <utility>

#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>

#include "address.hpp"
#include "server.hpp"

namespace binnacle::live {

namespace {

constexpr std::chrono::seconds visit_timeout{10};
constexpr std::uint32_t most_bytes = 8192;

}  // namespace

Visit::Visit(Server& server, boost::asio::ip::tcp::socket socket, std::shared_ptr<const void> ticket)
    : server_(server), stream_(std::move(socket)), ticket_(std::move(ticket)), buffer_(most_bytes) {
  parser_.header_limit(most_bytes);
}

void Visit::start() {
  stream_.expires_after(visit_timeout);
  http::async_read(stream_, buffer_, parser_,
                   [self = shared_from_this()](const auto& error, std::size_t) { self->answer(error); });
}

void Visit::answer(const boost::system::error_code& error) {
  if (!error) return answer_request();
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return refuse(http::status::request_header_fields_too_large, "a request may have 8 kB at most");
  if (error == http::error::unexpected_body)
    return refuse(http::status::payload_too_large, "a request may not have a body");
  if (error.category() == make_error_code(http::error::bad_method).category() && error != http::error::end_of_stream)
    return refuse(http::status::bad_request, "this is not an HTTP request");
}

void Visit::answer_request() {
  const auto& request = parser_.get();
  const auto host = request[http::field::host];
  if (!is_own_host({host.data(), host.size()}, server_.port()))
    return refuse(http::status::forbidden,
                  "the page is served to this machine's address in numbers, or localhost, "
                  "and its port; the request names another Host");
  const auto origin = request[http::field::origin];
  if (!origin.empty() && origin != "http://" + std::string(host))
    return refuse(http::status::forbidden, "the page's data are for the page; the request comes from another site");
  if (request.method() != http::verb::get) return refuse(http::status::method_not_allowed, "only GET is answered");
  if (request.target() == "/") return reply(http::status::ok, "text/html; charset=utf-8", server_.page());
  if (request.target() != "/events") return refuse(http::status::not_found, "only the page exists, at /");
  if (!server_.has_room_for_viewer())
    return refuse(http::status::service_unavailable, "the limit of open pages is reached");
  server_.add_viewer(stream_.release_socket(), std::move(ticket_));
}

void Visit::refuse(http::status status, const std::string& why) {
  reply(status, "text/plain; charset=utf-8", why + "\n");
}

void Visit::reply(http::status status, const char* type, std::string body) {
  response_.emplace(status, 11);
  if (status == http::status::method_not_allowed) response_->set(http::field::allow, "GET");
  response_->set(http::field::content_type, type);
  response_->set(http::field::cache_control, "no-store");
  response_->set("X-Content-Type-Options", "nosniff");
  response_->set("X-Frame-Options", "DENY");
  response_->set("Referrer-Policy", "no-referrer");
  response_->set("Cross-Origin-Resource-Policy", "same-origin");
  response_->keep_alive(false);
  response_->body() = std::move(body);
  response_->prepare_payload();
  stream_.expires_after(visit_timeout);
  http::async_write(stream_, *response_, [self = shared_from_this()](const auto&, std::size_t) {
    boost::system::error_code ignored;
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

}  // namespace binnacle::live
