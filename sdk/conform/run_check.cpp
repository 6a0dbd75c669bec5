// SPDX-License-Identifier: Apache-2.0
#include "catch.hpp"

#include <unistd.h>

#include <cstring>
#include <memory>
#include <thread>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"
#include "run_check.hpp"

namespace binnacle::conform {

namespace {

struct Current {
  const Check* check = nullptr;
  Trial* trial = nullptr;
  Wire wire;
} current;

void send(const Wire& wire, const char* kind, const std::string& message) {
  const std::string line = nlohmann::json({{"kind", kind}, {"message", message}})
                               .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) +
                           "\n";
  for (std::size_t sent = 0; sent < line.size();) {
    const auto count = ::write(wire.pipe, line.data() + sent, line.size() - sent);
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

class WireReport final : public Report {
 public:
  explicit WireReport(const Wire& wire) : wire_(wire) {}
  void failed(const std::string& message) override {
    send(wire_, "fail", message);
    FAIL_CHECK(message);
  }
  void warned(const std::string& message) override {
    send(wire_, "warn", message);
    WARN(message);
  }
  /// Of the thread that runs the check; a second one would race with it.
  void stage(const char* call) override {
    if (std::this_thread::get_id() == owner_) std::strncpy(wire_.stage, call, stage_bytes - 1);
  }

 private:
  Wire wire_;
  std::thread::id owner_ = std::this_thread::get_id();
};

}  // namespace

std::unique_ptr<Report> wire_report(const Wire& wire) { return std::make_unique<WireReport>(wire); }

int run_check(const Check& check, Trial& trial, const Wire& wire) {
  current = {&check, &trial, wire};
  Catch::Session session;
  const char* arguments[] = {"binnacle-conform", "--reporter", "compact"};
  if (session.applyCommandLine(3, arguments) != 0) return 1;
  return session.run();
}

}  // namespace binnacle::conform

TEST_CASE("conformance") {
  using namespace binnacle::conform;
  try {
    current.check->run(*current.trial);
    SUCCEED();
  } catch (const Skip& skip) {
    send(current.wire, "skip", skip.reason);
    SUCCEED();
  } catch (const std::exception& error) {
    const std::string during = current.wire.stage[0] ? std::string(" in ") + current.wire.stage + "()" : "";
    current.trial->fail("an exception crosses", during, ": ", error.what());
  } catch (...) {
    const std::string during = current.wire.stage[0] ? std::string(" in ") + current.wire.stage + "()" : "";
    current.trial->fail("something that is no std::exception crosses", during);
  }
  send(current.wire, "done", "");
}
