// SPDX-License-Identifier: Apache-2.0
#include "line_input/bytes.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <utility>

#include "endpoint.hpp"

namespace binnacle::line_input {

namespace {

using Clock = std::chrono::steady_clock;

std::string seconds_text(Clock::duration time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", std::chrono::duration<double>(time).count());
  return text;
}

}  // namespace

Time monotonic_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

bool is_live(const Parameters& parameters) {
  const bool from = parameters.has("from");
  if (from == parameters.has("path"))
    throw ComponentError("\"path\" of a file that is whole, or \"from\" of live input, is needed, and not both");
  if (!from && parameters.text("stamp") == "arrival")
    throw ComponentError("a recorded file has no times of arrival", "/stamp");
  return from;
}

std::string existing_path(const Parameters& parameters) {
  const std::string& path = parameters.text("path");
  if (!std::filesystem::exists(path))
    throw ComponentError::in_data("cannot be opened: No such file or directory", path, 0, "B060");
  return path;
}

struct Bytes::Intake {
  explicit Intake(const address::Address& address) : endpoint(address) {}

  struct Fault {
    std::int64_t count = 0, told_next = 1;
  };
  Endpoint endpoint;
  Reporter* reporter = nullptr;
  std::map<std::string, Fault> faults;
  Clock::time_point last = Clock::now();
  bool is_silent = false;
  std::int64_t losses_told_next = 1;
  Time arrival = no_time;  // of the newest
};

std::vector<ParameterSpec> Bytes::parameters(const std::string& unit) {
  return {parameter::path("from").about(
              "stdin:, file:PATH (followed as it grows), tcp://HOST:PORT, tcp://:PORT (a server), udp://:PORT, "
              "serial:///dev/ttyUSB0?baud=115200"),
          parameter::choice("stamp", {"data", "arrival"})
              .defaults("\"data\"")
              .about("data: a sample has the time in its data; arrival: the time of its arrival on the machine's "
                     "monotonic clock"),
          parameter::time("silence").above(0).defaults("\"5 s\"").about(
              "time without data after which a warning is reported"),
          parameter::choice("on_error", {"skip", "stop"})
              .defaults("\"skip\"")
              .about("skip: " + unit + " that is invalid is skipped, counted and reported; stop: it ends the run")};
}

Bytes::Bytes(const Parameters& parameters, bool ends_lines)
    : stamps_arrival_(parameters.text("stamp") == "arrival"),
      stops_(parameters.text("on_error") == "stop"),
      ends_lines_(ends_lines),
      silence_(parameters.time("silence")),
      intake_(std::make_unique<Intake>(address::parse(parameters.text("from"), address::Direction::input, "/from"))) {}

Bytes::~Bytes() = default;

int Bytes::wait_handle() const { return intake_->endpoint.wait_handle(); }

const std::string& Bytes::from() const { return intake_->endpoint.address().text; }

SourceFigures Bytes::figures() const { return {intake_->arrival, 0, intake_->endpoint.lost(), 0}; }

void Bytes::open(Reporter& reporter) {
  const address::Address address = intake_->endpoint.address();
  intake_ = std::make_unique<Intake>(address);
  intake_->reporter = &reporter;
  intake_->endpoint.open();
}

Bytes::Got Bytes::read(std::string& to, int line) {
  const auto got = intake_->endpoint.read(to, ends_lines_);
  if (got == Endpoint::Got::bytes) intake_->arrival = monotonic_now();
  watch_silence(got == Endpoint::Got::bytes, line);
  watch_losses(line);
  switch (got) {
    case Endpoint::Got::bytes: return Got::bytes;
    case Endpoint::Got::nothing: return Got::nothing;
    case Endpoint::Got::end: return Got::end;
    case Endpoint::Got::lost: return Got::lost;
    case Endpoint::Got::found: break;
  }
  return Got::found;
}

void Bytes::warn(const std::string& what, const char* code, int line) {
  intake_->reporter->warn(code, from(), line, what);
}

void Bytes::note(const std::string& what, const char* code, int line) {
  auto& fault = intake_->faults[what];
  if (++fault.count < fault.told_next) return;
  fault.told_next *= 10;
  warn(what + (fault.count == 1 ? "" : " (" + std::to_string(fault.count) + " times so far)"), code, line);
}

void Bytes::watch_losses(int line) {
  const auto lost = intake_->endpoint.lost();
  if (lost < intake_->losses_told_next) return;
  while (intake_->losses_told_next <= lost) intake_->losses_told_next *= 10;
  warn(std::to_string(lost) + " datagrams so far came faster than the filter runs and were lost", "B065", line);
}

void Bytes::watch_silence(bool came, int line) {
  Intake& intake = *intake_;
  const auto now = Clock::now();
  if (came) {
    if (std::exchange(intake.is_silent, false))
      warn("it came back after " + seconds_text(now - intake.last), "B065", line);
    intake.last = now;
  } else if (!intake.is_silent && now - intake.last > std::chrono::nanoseconds(silence_)) {
    intake.is_silent = true;
    warn("it has been silent for " + seconds_text(now - intake.last), "B065", line);
  }
}

}  // namespace binnacle::line_input
