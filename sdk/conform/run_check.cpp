// SPDX-License-Identifier: Apache-2.0
#include "run_check.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>

#include <nlohmann/json.hpp>

#include "attempt.hpp"
#include "binnacle/diagnostic.hpp"
#include "fixture.hpp"

namespace binnacle::conform {

namespace {

void send(const Wire& wire, const char* kind, const std::string& message) {
  if (wire.pipe < 0) {
    std::fprintf(stderr, "%s%s%s\n", kind, message.empty() ? "" : ": ", message.c_str());
    return;
  }
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
  void failed(const std::string& message) override { send(wire_, "fail", message); }
  void warned(const std::string& message) override { send(wire_, "warn", message); }
  /// Of the thread that runs the check; a second one would race with it.
  void stage(const char* call) override {
    if (std::this_thread::get_id() == owner_) std::strncpy(wire_.stage, call, stage_bytes - 1);
  }

 private:
  Wire wire_;
  std::thread::id owner_ = std::this_thread::get_id();
};

/// Where a component is examined its library stays until the process ends: what a model throws is read after the model
/// is gone. The checks of the library itself watch it come and go.
void keep_loaded(const Trial& trial) {
  if (!trial.type.empty()) ::dlopen(trial.library.c_str(), RTLD_LAZY | RTLD_LOCAL);
}

}  // namespace

std::unique_ptr<Report> wire_report(const Wire& wire) { return std::make_unique<WireReport>(wire); }

int run_check(const Check& check, Trial& trial, const Wire& wire) {
  keep_loaded(trial);
  const CallWatch watch(trial);
  attempt(
      check, trial, [&] { return std::string(wire.stage); },
      [&](const Skip& skip) { send(wire, skip.applies ? "skip" : "not applicable", skip.reason); });
  send(wire, "done", "");
  return trial.has_failed() ? 1 : 0;
}

}  // namespace binnacle::conform
