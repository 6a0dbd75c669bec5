// SPDX-License-Identifier: Apache-2.0
// Browser: a headless Chromium with one page, driven in its DevTools protocol through a pipe.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace binnacle::test {

using Json = nlohmann::ordered_json;

class Browser {
 public:
  /// Null where there is no chromium on the PATH.
  static std::unique_ptr<Browser> start();
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void size(int width, int height);
  /// A file, until it is loaded and its script says that it is ready.
  void open(const std::filesystem::path& page);
  /// The same of a page that a server has.
  void visit(const std::string& address);
  /// What the expression is; a promise's value. Throws where it throws.
  Json value_of(const std::string& expression);
  /// Throws when it is not true after a minute.
  void wait_for(const std::string& expression);
  void drag(double x0, double y0, double x1, double y1);
  void double_click(double x, double y);
  void prefer_dark(bool is_dark);
  /// Bytes of the page as a PDF.
  std::string printed();
  /// Everything that the page wrote to its console, and what it threw.
  const std::vector<std::string>& console() const { return console_; }
  /// Addresses of everything that was fetched, the page itself included.
  const std::vector<std::string>& requests() const { return requests_; }

 private:
  Browser() = default;
  void launch();
  Json call(const std::string& method, const Json& parameters = Json::object());
  Json next_message();
  void note(const Json& event);
  void mouse(const char* type, double x, double y, int clicks, bool is_down);

  std::filesystem::path profile_;
  int child_ = -1, to_ = -1, from_ = -1, last_id_ = 0;
  std::string received_, session_;
  std::vector<std::string> console_, requests_;
};

}  // namespace binnacle::test
