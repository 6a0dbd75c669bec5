// SPDX-License-Identifier: Apache-2.0
// nmea_writer's sentences, read again by the source: to the digit. What both say of wrong configs and data.
#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "drive.hpp"

namespace round_trip_test {

using namespace binnacle;
using namespace binnacle::drive;
using test::Workbench;

namespace {

std::string nmea_source(const std::string& path, const std::string& more = {}) {
  return R"({"back": {"type": "nmea", "path": ")" + path + R"(", "epoch": ")" + epoch + "\"" + more + "}}";
}

test::Outcome run(const Workbench& bench, const std::string& config) {
  bench.write("run.json", config);
  return test::binnacle(bench, {"run", "run.json", "--quiet"});
}

test::Outcome check(const Workbench& bench, const std::string& config) {
  bench.write("check.json", config);
  return test::binnacle(bench, {"check", "check.json"});
}

/// The simulated truth of the drive (10 Hz) as sentences; as JSON in truth.jsonl.
std::string written_truth(const Workbench& bench, const std::string& more = {}) {
  const auto outcome = run(bench, config("\"nmea\": " + nmea_writer("drive.truth", "file:out.nmea", more) +
                                         ", \"truth\": " + json_writer("drive.truth", "file:truth.jsonl")));
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return test::read_file(bench.path("out.nmea"));
}

/// What the source makes of a file: its warnings on stderr, samples in fix.jsonl and heading.jsonl.
test::Outcome read_back(const Workbench& bench, const std::string& nmea, const std::string& more = {}) {
  bench.write("in.nmea", nmea);
  bench.write("read.json", config("\"fix\": " + json_writer("back", "file:fix.jsonl") +
                                      ", \"heading\": " + json_writer("back.heading", "file:heading.jsonl"),
                                  nmea_source("in.nmea", more)));
  return test::binnacle(bench, {"run", "read.json"});
}

}  // namespace

TEST_CASE("what nmea_writer writes the nmea source reads again, to the digit, across midnight") {
  const Workbench bench;
  const std::string nmea = written_truth(bench);
  for (const auto& line : receivers::lines_of(nmea)) REQUIRE(line.size() + 1 <= 82);  // with its newline
  const auto outcome = read_back(bench, nmea);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK(outcome.err.empty());
  const auto truth = samples_of(test::read_file(bench.path("truth.jsonl")));
  const auto fixes = samples_of(test::read_file(bench.path("fix.jsonl")));
  const auto headings = samples_of(test::read_file(bench.path("heading.jsonl")));
  REQUIRE(truth.size() > 1800);
  REQUIRE(fixes.size() == truth.size());
  REQUIRE(headings.size() == truth.size());
  CHECK(truth.begin()->first < 120 * nanoseconds_per_second);
  CHECK(truth.rbegin()->first > 120 * nanoseconds_per_second);
  for (const auto& [t, is] : truth) {
    CAPTURE(seconds(t));
    REQUIRE(fixes.count(t) == 1);
    const auto& fix = fixes.at(t);
    const auto of = [&values = is](const char* name) { return values.at(name).get<double>(); };
    const auto error = [&](const char* name) { return std::abs(fix.at(name).get<double>() - of(name)); };
    REQUIRE(error("lat") <= half_a_digit_of_angle);
    REQUIRE(error("lon") <= half_a_digit_of_angle);
    REQUIRE(error("height") <= 2 * half_a_digit_of_height);  // above the sea, and the separation
    const double speed = std::hypot(of("vn"), of("ve"));
    REQUIRE(std::abs(fix.at("speed").get<double>() - speed) <= half_a_digit_of_speed);
    const double most = half_a_digit_of_speed + speed * half_a_digit_of_bearing + 1e-9;
    REQUIRE(error("vn") <= most);
    REQUIRE(error("ve") <= most);
    REQUIRE(fix.at("quality") == 6);
    const double yaw = headings.at(t).at("yaw").get<double>();
    REQUIRE(std::abs(turn_between(yaw, of("yaw"))) <= half_a_digit_of_bearing);
  }
}

TEST_CASE("sentences, talker, quality and their order are as asked") {
  const Workbench bench;
  const auto lines = receivers::lines_of(
      written_truth(bench, R"(, "sentences": ["HDT", "RMC", "GGA"], "talker": "IN", "quality": "rtk")"));
  REQUIRE(lines.size() > 3000);
  CHECK(lines[0].rfind("$INHDT,", 0) == 0);
  CHECK(lines[1].rfind("$INRMC,235800.000,A,", 0) == 0);
  CHECK(lines[1].find(",231126,,,R*") != std::string::npos);
  CHECK(lines[2].rfind("$INGGA,235800.000,", 0) == 0);
  CHECK(lines[2].find(",E,4,") != std::string::npos);
  CHECK(lines[3].rfind("$INHDT,", 0) == 0);
}

TEST_CASE("an estimate that is too uncertain is not valid") {
  const Workbench bench;
  const auto outcome =
      run(bench, config("\"nmea\": " + nmea_writer("ins", "file:out.nmea", R"(, "max_sigma": "0.45 m")") +
                        ", \"ins\": " + json_writer("ins", "file:ins.jsonl")));
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto lines = receivers::lines_of(test::read_file(bench.path("out.nmea")));
  const auto estimates = samples_of(test::read_file(bench.path("ins.jsonl")));
  REQUIRE(lines.size() == 4 * estimates.size());
  std::size_t valid = 0, i = 0;
  for (const auto& [t, estimate] : estimates) {
    const auto& sigma = estimate.at("sigma");
    const bool is_valid =
        std::hypot(sigma.at("position.north").get<double>(), sigma.at("position.east").get<double>()) <= 0.45;
    CAPTURE(seconds(t), lines[i], lines[i + 1]);
    REQUIRE((lines[i].find(",E,6,,,") != std::string::npos) == is_valid);
    REQUIRE((lines[i].find(",,,,,0,,,,M,,M,,*") != std::string::npos) == !is_valid);
    REQUIRE((lines[i + 1].find(",A,") != std::string::npos) == is_valid);
    REQUIRE((lines[i + 1].find(",N*") != std::string::npos) == !is_valid);
    valid += is_valid;
    i += 4;
  }
  CHECK(valid > 10);
  CHECK(valid + 10 < estimates.size());
}

TEST_CASE("damaged sentences are left out, counted and reported with the line of the first, and the others are read") {
  const Workbench bench;
  const std::string nmea = written_truth(bench);
  auto lines = receivers::lines_of(nmea);
  lines[41] = lines[41].substr(0, 20);               // a sentence cut
  lines[80][30] = lines[80][30] == '1' ? '2' : '1';  // a digit changed
  lines[90] = "\x01\x02 what no one can read";       // no sentence
  lines[122] = sentence("GPHDT,abc,T");              // a field that is no number
  std::string damaged;
  for (const auto& line : lines) damaged += line + "\n";
  const auto outcome = read_back(bench, damaged + "$GPGGA,0001");
  INFO(outcome.err);
  CHECK(outcome.status == 0);
  CHECK(
      outcome.err.find("in.nmea:42: warning[B061] /sources/back: 2 sentences cut, or without a checksum; the first: '" +
                       lines[41] + "'") != std::string::npos);
  CHECK(outcome.err.find("in.nmea:81: warning[B061] /sources/back: 1 sentence of which the checksum is wrong") !=
        std::string::npos);
  CHECK(outcome.err.find(
            "in.nmea:123: warning[B062] /sources/back: 1 sentence with a field that cannot be read; the first: "
            "'$GPHDT,abc,T*7B'") != std::string::npos);
  CHECK(samples_of(test::read_file(bench.path("fix.jsonl"))).size() ==
        samples_of(test::read_file(bench.path("truth.jsonl"))).size());
  const auto stopped = read_back(bench, damaged, R"(, "on_error": "stop")");
  CHECK(stopped.status == 5);
  CHECK(stopped.err.find("in.nmea:42: error[B061]") != std::string::npos);
}

TEST_CASE("data without a position, without a date, or without a file are refused") {
  const Workbench bench;
  const auto none = read_back(bench, sentence("GPGSV,3,1,11,03,03,111,00") + "\r\n");
  CHECK(none.status == 5);
  CHECK(none.err.find("error[B066] /sources/back: no sentence gives a position or a heading with a date") !=
        std::string::npos);
  const std::string gga = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  CHECK(read_back(bench, gga).status == 5);
  CHECK(read_back(bench, gga, R"(, "date": "2026-11-23")").status == 0);
  const auto missing = check(bench, config("", nmea_source("nothing.nmea")));
  CHECK(missing.status == 5);
  CHECK(missing.err.find("B060") != std::string::npos);
}

TEST_CASE("GST gives standard deviations, where they are asked for") {
  const Workbench bench;
  const std::string position = ",4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,";
  const std::string nmea = sentence("GPGGA,120000" + position) + "\r\n" + sentence("GPGST,120000,1,2,3,4,1.5,2.5,3.5") +
                           "\r\n" + sentence("GPGGA,120001" + position) + "\r\n";
  const auto outcome = read_back(bench, nmea, R"(, "date": "2026-11-23", "gst": true)");
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto fixes = samples_of(test::read_file(bench.path("fix.jsonl")));
  REQUIRE(fixes.size() == 2);
  CHECK(fixes.begin()->second.at("position_sd_n") == 1.5);
  CHECK(fixes.begin()->second.at("position_sd_e") == 2.5);
  CHECK(fixes.begin()->second.at("position_sd_d") == 3.5);
  CHECK(fixes.rbegin()->second.at("position_sd_n").is_null());
}

TEST_CASE("what is wrong with a nmea_writer or a nmea source is said at its place") {
  const Workbench bench;
  const auto error_of = [&](const std::string& sink) {
    const auto outcome = check(bench, config("\"nmea\": " + sink));
    CHECK(outcome.status == 3);
    return outcome.err;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
  };
  has(error_of(R"({"type": "nmea_writer", "input": "drive.truth", "to": "file:x"})"),
      "sentences carry UTC: give 'week'");
  has(error_of(nmea_writer("drive.truth", "file:x", R"(, "week": 3)")), "/sinks/nmea/epoch: 'week' is given too");
  has(error_of(nmea_writer("drive.truth", "file:x", R"(, "talker": "gps")")),
      "/sinks/nmea/talker: 'gps' is not a talker");
  has(error_of(nmea_writer("drive.imu", "file:x")), "the channel has no field for a sentence");
  has(error_of(nmea_writer("drive.gnss", "file:x", R"(, "sentences": ["GGA", "HDT"])")), "HDT needs 'yaw'");
  has(error_of(nmea_writer("drive.truth", "file:x", R"(, "max_sigma": "3 m")")),
      "/sinks/nmea/max_sigma: the channel's covariance has no component 'north' in m");
  has(error_of(nmea_writer("drive.truth", "tcp:/oops")), "/sinks/nmea/to: ");
  bench.write("some.nmea", "$GPHDT,123.456,T*32\n");
  const auto source_error = [&](const std::string& more) {
    return check(bench, config("", nmea_source("some.nmea", more))).err;
  };
  has(source_error(R"(, "ends_with": "RM")"), "/sources/back/ends_with: 'RM' is not a sentence");
  has(source_error(R"(, "date": "yesterday")"), "/sources/back/date: 'yesterday' is not a day");
  const auto warned =
      check(bench, config(R"("nmea": {"type": "nmea_writer", "input": "drive.truth", "to": "file:x", "week": 2400})"));
  CHECK(warned.status == 0);
  has(warned.err, "GGA has no height");
}

}  // namespace round_trip_test
