// SPDX-License-Identifier: Apache-2.0
// gpsd, the program of Debian that reads most receivers, reads what nmea_writer sends through a pseudo-terminal.
#include <atomic>
#include <cmath>
#include <csignal>
#include <thread>

#include <sys/wait.h>

#include "catch.hpp"
#include "civil_time/utc_clock.hpp"
#include "drive.hpp"
#include "skip.hpp"

namespace gpsd_test {

using namespace binnacle;
using namespace binnacle::drive;
using namespace binnacle::receivers;
using test::Workbench;

namespace {

std::string gpsd_program() {
  for (const char* path : {"/usr/sbin/gpsd", "/usr/local/sbin/gpsd", "/usr/bin/gpsd"})
    if (::access(path, X_OK) == 0) return path;
  return {};
}

/// A gpsd on a port of its own, and what it reports as JSON.
class Gpsd {
 public:
  Gpsd(const std::string& source, const std::string& log) : port_(free_port()), child_(::fork()) {
    if (child_ == 0) {
      const int file = ::open(log.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
      ::dup2(file, STDERR_FILENO);
      ::dup2(file, STDOUT_FILENO);
      const std::string port = std::to_string(port_), program = gpsd_program();
      ::execl(program.c_str(), "gpsd", "-N", "-n", "-b", "-p", "-S", port.c_str(), source.c_str(), nullptr);
      ::_exit(126);
    }
    client_ = std::make_unique<Reading>(connected(port_));
    const std::string watch = "?WATCH={\"enable\":true,\"json\":true};\n";
    if (::write(client_->fd(), watch.data(), watch.size()) < 0)
      throw std::runtime_error("gpsd does not take a command");
  }
  ~Gpsd() {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  Gpsd(const Gpsd&) = delete;
  Gpsd& operator=(const Gpsd&) = delete;

  /// Until it opened its device.
  std::string wait_until_open() const {
    std::string text;
    while (text.find("\"activated\"") == text.npos || text.back() != '\n') {
      const std::string more = client_->bytes(1);
      if (more.empty()) break;
      text += more;
    }
    return text;
  }
  std::string reports() const { return client_->all(); }

 private:
  int port_;
  int child_;
  std::unique_ptr<Reading> client_;
};

/// What comes out of one terminal goes into the other, as through a cable.
class Cable {
 public:
  Cable(const Reading& from, const Reading& to) : thread_([this, &from, &to] { carry(from.fd(), to.fd()); }) {}
  ~Cable() {
    is_over_ = true;
    thread_.join();
  }

 private:
  void carry(int from, int to) const {
    char bytes[4096];
    while (!is_over_) {
      pollfd handle{from, POLLIN, 0};
      if (::poll(&handle, 1, 50) <= 0 || (handle.revents & POLLIN) == 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      const auto count = ::read(from, bytes, sizeof bytes);
      for (ssize_t sent = 0; sent < count;) {
        const auto more = ::write(to, bytes + sent, static_cast<std::size_t>(count - sent));
        if (more <= 0) return;
        sent += more;
      }
    }
  }
  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

/// "2026-11-23T23:58:01.000Z" on the drive's clock.
Time time_of(const std::string& text) {
  const auto whole = nmea::parse_instant(text.substr(0, 19));
  REQUIRE(whole);
  return *whole - *nmea::parse_instant(epoch) + nanoseconds(std::stod("0" + text.substr(19, text.size() - 20)));
}

/// One TPV report against the estimate of its time.
void compare(const nlohmann::json& report, const nlohmann::json& estimate) {
  constexpr double last_degree = 0.5e-9 * degree, last_digit = 0.5e-3;  // gpsd's own
  const auto is = [&](const char* name) { return report.at(name).get<double>(); };
  const auto of = [&](const char* name) { return estimate.at(name).get<double>(); };
  INFO(report << "\n" << estimate);
  REQUIRE(std::abs(is("lat") * degree - of("position.lat")) <= half_a_digit_of_angle + last_degree);
  REQUIRE(std::abs(is("lon") * degree - of("position.lon")) <= half_a_digit_of_angle + last_degree);
  REQUIRE(std::abs(is("altHAE") - of("position.height")) <= 2 * half_a_digit_of_height + last_digit);
  const double vn = of("velocity.vn"), ve = of("velocity.ve");
  REQUIRE(std::abs(is("speed") - std::hypot(vn, ve)) <= half_a_digit_of_speed + last_digit);
  REQUIRE(std::abs(turn_between(is("track") * degree, std::atan2(ve, vn))) <=
          half_a_digit_of_bearing + last_digit * degree);
  REQUIRE(report.at("mode") == 3);
  REQUIRE(report.at("status") == 5);  // dead reckoning: what quality 6 is
}

/// Of all reports; how many had a position.
std::size_t compare_all(const std::string& reports, const std::map<Time, nlohmann::json>& estimates) {
  std::size_t positions = 0, headings = 0;
  Time t = no_time;
  for (const auto& line : lines_of(reports)) {
    const auto report = nlohmann::json::parse(line);
    if (report.at("class") == "TPV" && report.contains("lat")) {
      t = time_of(report.at("time").get<std::string>());
      REQUIRE(estimates.count(t) == 1);
      compare(report, estimates.at(t));
      ++positions;
    }
    if (report.at("class") == "ATT" && report.contains("heading")) ++headings;
  }
  CHECK(headings > 0);
  return positions;
}

}  // namespace

TEST_CASE("gpsd reads the estimates from a pseudo-terminal as they are") {
  if (gpsd_program().empty()) return test::skip("no gpsd (Debian package gpsd)");
  const Workbench bench;
  Terminal ours, theirs;
  const Reading keeps_it_open(::open(theirs.device().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  const Gpsd gpsd(theirs.device(), bench.beside("gpsd"));
  INFO(gpsd.wait_until_open() << test::read_file(bench.beside("gpsd")));
  bench.write("live.json", config("\"nmea\": " + nmea_writer("ins", "serial://" + ours.device() + "?baud=4000000") +
                                  ", \"ins\": " + json_writer("ins", "file:ins.jsonl")));
  test::Outcome outcome;
  std::string reports;
  {
    const Cable cable(ours.master(), theirs.master());
    std::thread reader([&] { reports = gpsd.reports(); });
    outcome = test::binnacle(bench, {"run", "live.json", "--quiet"});
    reader.join();
  }
  REQUIRE(outcome.status == 0);
  CHECK(outcome.err.empty());
  const auto estimates = samples_of(test::read_file(bench.path("ins.jsonl")));
  REQUIRE(estimates.size() > 190);
  CHECK(compare_all(reports, estimates) + 2 >= estimates.size());  // it learns where an epoch ends from the first two
}

}  // namespace gpsd_test
