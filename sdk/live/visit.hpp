// SPDX-License-Identifier: Apache-2.0
// Visit: a connection with one request.
#pragma once

#include <memory>
#include <optional>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

namespace binnacle::live {

namespace beast = boost::beast;
namespace http = boost::beast::http;

class Server;

/// Answers GET / with the page and GET /events with a viewer, everything else with a refusal in one line.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(Server& server, boost::asio::ip::tcp::socket socket, std::shared_ptr<const void> ticket);
  void start();

 private:
  void answer(const boost::system::error_code& error);
  void answer_request();
  void refuse(http::status status, const std::string& why);
  void reply(http::status status, const char* type, std::string body);

  Server& server_;
  beast::tcp_stream stream_;
  std::shared_ptr<const void> ticket_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  std::optional<http::response<http::string_body>> response_;
};

}  // namespace binnacle::live
