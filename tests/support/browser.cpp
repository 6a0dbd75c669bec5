// SPDX-License-Identifier: Apache-2.0
#include "browser.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

namespace binnacle::test {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto timeout = 60s;

fs::path chromium() {
  const char* const path = std::getenv("PATH");
  std::string folders = path ? path : "";
  for (std::size_t begin = 0; begin <= folders.size();) {
    const auto end = std::min(folders.find(':', begin), folders.size());
    const fs::path program = fs::path(folders.substr(begin, end - begin)) / "chromium";
    if (::access(program.c_str(), X_OK) == 0) return program;
    begin = end + 1;
  }
  return {};
}

/// Fresh, since a profile in use is refused.
fs::path temporary_folder() {
  std::string name = (fs::temp_directory_path() / "binnacle-browser-XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder could be made");
  return name;
}

/// Chromium reads its commands from 3 and answers on 4.
[[noreturn]] void become_chromium(const fs::path& program, const fs::path& profile, int commands, int answers) {
  ::setpgid(0, 0);
  const int null = ::open("/dev/null", O_RDWR);
  for (const int standard : {0, 1, 2}) ::dup2(null, standard);
  // Past 3 and 4 first, so that neither is overwritten before it is moved.
  const int in = ::fcntl(commands, F_DUPFD, 10), out = ::fcntl(answers, F_DUPFD, 10);
  ::dup2(in, 3);
  ::dup2(out, 4);
  const std::string data = "--user-data-dir=" + profile.string();
  ::execl(program.c_str(), "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic",
          "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
          "--disable-dev-shm-usage", "--hide-scrollbars", data.c_str(), "--remote-debugging-pipe", "about:blank",
          static_cast<char*>(nullptr));
  ::_exit(127);
}

}  // namespace

std::unique_ptr<Browser> Browser::start() {
  if (chromium().empty()) return nullptr;
  std::unique_ptr<Browser> browser(new Browser);
  browser->launch();
  const std::string target = browser->call("Target.createTarget", {{"url", "about:blank"}}).at("targetId");
  browser->session_ = browser->call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}}).at("sessionId");
  for (const char* domain : {"Page.enable", "Runtime.enable", "Log.enable", "Network.enable"}) browser->call(domain);
  return browser;
}

void Browser::launch() {
  std::signal(SIGPIPE, SIG_IGN);
  profile_ = temporary_folder();
  int commands[2], answers[2];
  if (::pipe2(commands, O_CLOEXEC) != 0 || ::pipe2(answers, O_CLOEXEC) != 0)
    throw std::runtime_error("no pipe could be made");
  child_ = ::fork();
  if (child_ < 0) throw std::runtime_error("no process could be started");
  if (child_ == 0) become_chromium(chromium(), profile_, commands[0], answers[1]);
  ::close(commands[0]);
  ::close(answers[1]);
  to_ = commands[1];
  from_ = answers[0];
}

Browser::~Browser() {
  if (to_ >= 0) ::close(to_);
  if (from_ >= 0) ::close(from_);
  if (child_ > 0) {
    ::kill(-child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  std::error_code ignored;
  for (int attempt = 0; attempt < 20 && fs::exists(profile_, ignored); ++attempt) {
    fs::remove_all(profile_, ignored);
    std::this_thread::sleep_for(50ms);
  }
}

Json Browser::call(const std::string& method, const Json& parameters) {
  Json command{{"id", ++last_id_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) command["sessionId"] = session_;
  const std::string text = command.dump() + '\0';
  for (std::size_t at = 0; at < text.size();) {
    const auto written = ::write(to_, text.data() + at, text.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw std::runtime_error("chromium has ended");
    at += static_cast<std::size_t>(written);
  }
  for (;;) {
    const Json message = next_message();
    if (!message.contains("id")) {
      note(message);
      continue;
    }
    if (message.at("id") != Json(last_id_)) continue;
    if (message.contains("error")) throw std::runtime_error(method + ": " + message.at("error").dump());
    return message.at("result");
  }
}

Json Browser::next_message() {
  const auto deadline = Clock::now() + timeout;
  for (;;) {
    if (const auto end = received_.find('\0'); end != std::string::npos) {
      Json message = Json::parse(received_.substr(0, end));
      received_.erase(0, end + 1);
      return message;
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd waiting{from_, POLLIN, 0};
    if (left <= 0 || ::poll(&waiting, 1, static_cast<int>(left)) == 0)
      throw std::runtime_error("chromium says nothing");
    char buffer[65536];
    const auto count = ::read(from_, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw std::runtime_error("chromium has ended");
    received_.append(buffer, static_cast<std::size_t>(count));
  }
}

void Browser::note(const Json& event) {
  const std::string method = event.value("method", "");
  if (method == "Runtime.consoleAPICalled" || method == "Runtime.exceptionThrown" || method == "Log.entryAdded")
    console_.push_back(event.at("params").dump());
  if (method == "Network.requestWillBeSent") requests_.push_back(event.at("params").at("request").at("url"));
}

void Browser::size(int width, int height) {
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

void Browser::open(const fs::path& page) { visit("file://" + page.string()); }

void Browser::visit(const std::string& address) {
  call("Page.navigate", {{"url", address}});
  wait_for("document.readyState === 'complete' && document.documentElement.dataset.ready === 'yes'");
}

Json Browser::value_of(const std::string& expression) {
  const Json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (answer.contains("exceptionDetails"))
    throw std::runtime_error(expression + ": " + answer.at("exceptionDetails").dump());
  return answer.at("result").contains("value") ? answer.at("result").at("value") : Json(nullptr);
}

void Browser::wait_for(const std::string& expression) {
  const auto deadline = Clock::now() + timeout;
  while (value_of(expression) != Json(true)) {
    if (Clock::now() > deadline)
      throw std::runtime_error("never true: " + expression + (console_.empty() ? "" : "; " + console_.front()));
    std::this_thread::sleep_for(20ms);
  }
}

void Browser::mouse(const char* type, double x, double y, int clicks, bool is_down) {
  call("Input.dispatchMouseEvent", {{"type", type},
                                    {"x", x},
                                    {"y", y},
                                    {"button", clicks > 0 || is_down ? "left" : "none"},
                                    {"buttons", is_down ? 1 : 0},
                                    {"clickCount", clicks}});
}

void Browser::drag(double x0, double y0, double x1, double y1) {
  mouse("mouseMoved", x0, y0, 0, false);
  mouse("mousePressed", x0, y0, 1, true);
  for (const double share : {0.25, 0.5, 0.75, 1.0})
    mouse("mouseMoved", x0 + share * (x1 - x0), y0 + share * (y1 - y0), 0, true);
  mouse("mouseReleased", x1, y1, 1, false);
}

void Browser::double_click(double x, double y) {
  for (const int count : {1, 2}) {
    mouse("mousePressed", x, y, count, true);
    mouse("mouseReleased", x, y, count, false);
  }
}

void Browser::prefer_dark(bool is_dark) {
  call("Emulation.setEmulatedMedia",
       {{"features", Json::array({{{"name", "prefers-color-scheme"}, {"value", is_dark ? "dark" : "light"}}})}});
}

std::string Browser::printed() {
  return call("Page.printToPDF", {{"preferCSSPageSize", true}, {"printBackground", true}}).at("data");
}

}  // namespace binnacle::test
