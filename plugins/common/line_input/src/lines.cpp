// SPDX-License-Identifier: Apache-2.0
#include "line_input/lines.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
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

/// A line that is longer is no line.
constexpr std::size_t longest_line = 1 << 20;

}  // namespace

Time monotonic_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

struct Lines::Intake {
  explicit Intake(const address::Address& address) : endpoint(address) {}

  struct Fault {
    std::int64_t count = 0, told_next = 1;
  };
  Endpoint endpoint;
  Reporter* reporter = nullptr;
  std::string buffer;
  std::size_t begin = 0;  // of what was not taken yet
  int line = 0;
  bool is_cut = false;  // the rest of a line that was given up
  std::map<std::string, Fault> faults;
  Clock::time_point last = Clock::now();
  bool is_silent = false;
  std::int64_t losses_told_next = 1;
  std::int64_t waiting = 0, unusable = 0;  // lines
  Time arrival = no_time;                  // of the newest

  const std::string& from() const { return endpoint.address().text; }
};

std::vector<ParameterSpec> Lines::parameters() {
  return {parameter::path("from").about(
              "stdin:, file:PATH (followed as it grows), tcp://HOST:PORT, tcp://:PORT (a server), udp://:PORT, "
              "serial:///dev/ttyUSB0?baud=115200"),
          parameter::choice("stamp", {"data", "arrival"})
              .defaults("\"data\"")
              .about("data: a sample has the time that it carries; arrival: that of the machine's monotonic clock when "
                     "it came"),
          parameter::time("silence").above(0).defaults("\"5 s\"").about(
              "when nothing came for so long, a warning says so"),
          parameter::choice("on_error", {"skip", "stop"})
              .defaults("\"skip\"")
              .about("skip: a line that is no good is left out, counted and reported; stop: it ends the run")};
}

Lines::Lines(const Parameters& parameters)
    : stamps_arrival_(parameters.text("stamp") == "arrival"),
      stops_(parameters.text("on_error") == "stop"),
      silence_(parameters.time("silence")),
      intake_(std::make_unique<Intake>(address::parse(parameters.text("from"), address::Direction::input, "/from"))) {}

Lines::~Lines() = default;

int Lines::wait_handle() const { return intake_->endpoint.wait_handle(); }

SourceFigures Lines::figures() const {
  return {intake_->arrival, intake_->waiting, intake_->endpoint.lost(), intake_->unusable};
}

void Lines::open(Reporter& reporter) {
  const address::Address address = intake_->endpoint.address();
  intake_ = std::make_unique<Intake>(address);
  intake_->reporter = &reporter;
  intake_->endpoint.open();
}

Lines::Got Lines::next(std::string_view& line) {
  Intake& intake = *intake_;
  for (;;) {
    if (take_line(line)) return Got::line;
    intake.buffer.erase(0, intake.begin);
    intake.begin = 0;
    if (intake.buffer.size() > longest_line) {
      intake.buffer.clear();
      intake.is_cut = true;
      complain("it has no end within a megabyte");
    }
    const std::size_t before = intake.buffer.size();
    const auto got = intake.endpoint.read(intake.buffer);
    if (got == Endpoint::Got::bytes) {
      intake.arrival = monotonic_now();
      intake.waiting +=
          std::count(intake.buffer.begin() + static_cast<std::ptrdiff_t>(before), intake.buffer.end(), '\n');
    }
    watch_silence(got == Endpoint::Got::bytes);
    watch_losses();
    if (got == Endpoint::Got::nothing) return Got::nothing;
    if (got == Endpoint::Got::end) {
      if (intake.buffer.empty()) return Got::end;
      intake.buffer += '\n';  // the last line may lack its end
      ++intake.waiting;
    }
    if (got == Endpoint::Got::lost || got == Endpoint::Got::found) {
      if (!intake.buffer.empty()) complain("the connection was lost in the middle of it");
      intake.buffer.clear();
      intake.reporter->warn("B067", intake.from(), intake.line,
                            got == Endpoint::Got::lost
                                ? "nobody is there, or the connection was lost; it is tried again each second"
                                : "the connection is there again");
      return Got::anew;
    }
  }
}

/// A whole one that is not empty.
bool Lines::take_line(std::string_view& line) {
  Intake& intake = *intake_;
  for (;;) {
    const auto end = intake.buffer.find('\n', intake.begin);
    if (end == std::string::npos) return false;
    line = std::string_view(intake.buffer).substr(intake.begin, end - intake.begin);
    intake.begin = end + 1;
    ++intake.line;
    --intake.waiting;
    if (std::exchange(intake.is_cut, false)) continue;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \t") != line.npos) return true;
  }
}

void Lines::complain(const std::string& why, const char* code) {
  ++intake_->unusable;
  if (stops_) throw ComponentError::in_data("the line is no good: " + why, intake_->from(), intake_->line, code);
  note("a line is no good: " + why, code);
}

void Lines::note(const std::string& what, const char* code) {
  auto& fault = intake_->faults[what];
  if (++fault.count < fault.told_next) return;
  fault.told_next *= 10;
  const std::string times = fault.count == 1 ? "" : " (" + std::to_string(fault.count) + " times so far)";
  intake_->reporter->warn(code, intake_->from(), intake_->line, what + times);
}

void Lines::watch_losses() {
  Intake& intake = *intake_;
  const auto lost = intake.endpoint.lost();
  if (lost < intake.losses_told_next) return;
  while (intake.losses_told_next <= lost) intake.losses_told_next *= 10;
  intake.reporter->warn("B065", intake.from(), intake.line,
                        std::to_string(lost) + " datagrams so far came faster than the filter works, and were lost");
}

void Lines::watch_silence(bool came) {
  Intake& intake = *intake_;
  const auto now = Clock::now();
  if (came) {
    if (std::exchange(intake.is_silent, false))
      intake.reporter->warn("B065", intake.from(), intake.line,
                            "it came back after " + seconds_text(now - intake.last));
    intake.last = now;
  } else if (!intake.is_silent && now - intake.last > std::chrono::nanoseconds(silence_)) {
    intake.is_silent = true;
    intake.reporter->warn("B065", intake.from(), intake.line,
                          "it has been silent for " + seconds_text(now - intake.last));
  }
}

}  // namespace binnacle::line_input
