// SPDX-License-Identifier: Apache-2.0
// The configs of configs/drives on the recorded drives: figures that must be reached, health, and that every sample is
// accounted for.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "catch.hpp"
#include "recorded.hpp"

namespace drives_test {

using namespace binnacle;
using nlohmann::ordered_json;

namespace {

/// What a drive must reach, and how much of it there is.
struct Drive {
  const char* config;
  double fixes_rms;     // horizontal, of the GNSS fixes themselves against the reference, m: README of the data
  double withheld_rms;  // horizontal, at most, against every second fix when these are withheld, m
  int fixes;            // rows of gnss.csv.gz
  int positions;        // rows of reference_position.csv.gz from 60 s on that have a position
  double end;           // last row of imu.csv.gz, s
};
const std::vector<Drive> drives = {{"long-drive-large-mount", 0.85, 0.25, 2556, 36935, 1278.803943508},
                                   {"parkinglot", 1.44, 0.46, 1292, 18251, 662.270171962},
                                   {"medium-turn-loop", 0.77, 0.25, 619, 7560, 309.476627470},
                                   {"mixed-turns", 1.92, 0.46, 1043, 13986, 521.512427615},
                                   {"stop-go-large-mount", 1.08, 0.25, 950, 13043, 490.394164011}};

ordered_json run_drive(const std::filesystem::path& folder, const std::string& config, std::vector<std::string> sets) {
  return recorded::run(folder, "drives/" + config, std::move(sets));
}

double figure(const ordered_json& filter, const std::string& error, const std::string& statistic = "rms") {
  CAPTURE(error);
  REQUIRE(filter.at("reference").contains(error));
  return filter.at("reference").at(error).at(statistic).get<double>();
}

/// Each sample offered has one outcome, and each row of the file was offered or came before the start.
void check_ledger(const ordered_json& filter, int rows) {
  for (const auto& [name, counts] : filter.at("measurements").items()) {
    INFO(name << ": " << counts.dump());
    std::int64_t outcomes = 0;
    for (const char* outcome : {"accepted", "gated", "late", "unsupported", "invalid", "withheld", "rejected"})
      outcomes += counts.at(outcome).get<std::int64_t>();
    CHECK(counts.at("offered").get<std::int64_t>() == outcomes);
    if (name == "fix")
      CHECK(counts.at("offered").get<std::int64_t>() + counts.at("before_start").get<std::int64_t>() == rows);
    CHECK(counts.at("late") == 0);
    CHECK(counts.at("invalid") == 0);
    CHECK(counts.at("rejected") == 0);
  }
}

/// From 60 s on, or from the start where that is later, all of the reference's rows are scored; they come at a steady rate.
void check_scored(const ordered_json& filter, const Drive& drive) {
  const double start = filter.at("start_s").get<double>();
  const double rows = drive.positions * (drive.end - std::max(60.0, start)) / (drive.end - 60.0);
  CAPTURE(start, rows);
  CHECK(std::abs(figure(filter, "position.horizontal", "n") - rows) <= 3);
  CHECK(std::abs(figure(filter, "attitude.yaw", "n") - rows) <= 3);
}

}  // namespace

TEST_CASE("recorded drives against their reference") {
  const auto folder = recorded::data();
  if (!folder) return;
  std::printf("\n%-24s horizontal (at most)   height velocity    roll   pitch     yaw  NIS/dof    started\n",
              "reference, RMS");
  for (const Drive& drive : drives) {
    INFO(drive.config);
    const ordered_json ins = run_drive(*folder, drive.config, {}).at("filters").at("ins");
    const double horizontal = figure(ins, "position.horizontal"), roll = figure(ins, "attitude.roll"),
                 pitch = figure(ins, "attitude.pitch"), yaw = figure(ins, "attitude.yaw");
    const double most = 1.05 * drive.fixes_rms;
    const auto& fix = ins.at("measurements").at("fix");
    std::printf("%-24s %8.3f m (%6.3f) %8.3f %8.3f %7.3f %7.3f %7.3f  %5.2f/%.0f %7.1f s\n", drive.config, horizontal,
                most, figure(ins, "position.down"), figure(ins, "velocity.horizontal"), roll, pitch, yaw,
                fix.at("nis_mean").get<double>(), fix.at("dof").get<double>(), ins.at("start_s").get<double>());
    CHECK(horizontal <= most);
    if (std::string(drive.config) == "long-drive-large-mount") {
      CHECK(roll <= 0.35);
      CHECK(pitch <= 0.35);
      CHECK(yaw <= 0.75);
    }
    check_ledger(ins, drive.fixes);
    check_scored(ins, drive);
    CHECK_FALSE(ins.contains("broken"));
    CHECK_FALSE(ins.contains("input_gaps"));
    CHECK(std::abs(ins.at("end_s").get<double>() - drive.end) < 2e-9);
  }
}

TEST_CASE("recorded drives against every second fix, withheld") {
  const auto folder = recorded::data();
  if (!folder) return;
  std::printf("\n%-24s horizontal (at most)    95 %%\n", "withheld fixes, RMS");
  for (const Drive& drive : drives) {
    INFO(drive.config);
    const ordered_json ins =
        run_drive(*folder, drive.config,
                  {R"(/filters/ins/measurements/fix/withhold={"every": 2})", R"(/reference={"withheld": "fix"})"})
            .at("filters")
            .at("ins");
    const double horizontal = figure(ins, "position.horizontal");
    std::printf("%-24s %8.3f m (%6.3f) %8.3f\n", drive.config, horizontal, drive.withheld_rms,
                figure(ins, "position.horizontal", "p95"));
    CHECK(horizontal <= drive.withheld_rms);
    check_ledger(ins, drive.fixes);
    const auto& fix = ins.at("measurements").at("fix");
    CHECK(fix.at("withheld").get<int>() == fix.at("offered").get<int>() / 2);
  }
}

TEST_CASE("twenty outages of 30 s on recorded drives") {
  const auto folder = recorded::data();
  if (!folder) return;
  const ordered_json summary = run_drive(*folder, "outages", {});
  std::vector<double> ends, without_faulty;
  std::printf("\n30 s outage, horizontal error at its end\n");
  for (const auto& [name, filter] : summary.at("filters").items()) {
    INFO(name);
    const auto drive = std::find_if(drives.begin(), drives.end(), [&, &name = name](const Drive& candidate) {
      std::string config = candidate.config;
      std::replace(config.begin(), config.end(), '-', '_');
      return config.rfind(name, 0) == 0;
    });
    REQUIRE(drive != drives.end());
    check_ledger(filter, drive->fixes);
    CHECK_FALSE(filter.contains("broken"));
    for (const auto& [window, figures] : filter.at("windows").items()) {
      const double end = figures.at("position.horizontal").at("final").get<double>();
      std::printf("  %-24s %7.2f m\n", window.c_str(), end);
      ends.push_back(end);
      // The receiver's velocity is faulty from 440 s on.
      if (window != "mixed_turns 436") without_faulty.push_back(end);
    }
  }
  REQUIRE(ends.size() == 20);
  REQUIRE(without_faulty.size() == 19);
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  std::sort(ends.begin(), ends.end());
  const double median = 0.5 * (ends[9] + ends[10]);
  std::printf("  median %.2f m (6.5), mean %.2f m (8.3), mean without mixed_turns 436 %.2f m\n", median, mean(ends),
              mean(without_faulty));
  CHECK(median <= 6.5);
  CHECK(mean(ends) <= 8.3);
  CHECK(mean(without_faulty) <= 8.3);
  const auto& reported = summary.at("windows").at("position.horizontal").at("final");
  CHECK(std::abs(reported.at("p50").get<double>() - median) < 1e-9);
  CHECK(std::abs(reported.at("mean").get<double>() - mean(ends)) < 1e-9);
}

TEST_CASE("the clock of a recorded drive may be shifted, and a part of it be cut out") {
  const auto folder = recorded::data();
  if (!folder) return;
  const std::vector<std::string> sources = {"raw_imu", "gnss", "reference_position", "reference_attitude"};
  const std::string config = "medium-turn-loop";
  const auto& drive = drives[2];

  std::vector<std::string> shift = {"/evaluate/after=1060 s"};
  for (const auto& source : sources) shift.push_back("/sources/" + source + "/time/offset=1000 s");
  const ordered_json plain = run_drive(*folder, config, {}).at("filters").at("ins");
  const ordered_json shifted = run_drive(*folder, config, shift).at("filters").at("ins");
  check_ledger(shifted, drive.fixes);
  CHECK(std::abs(shifted.at("start_s").get<double>() - plain.at("start_s").get<double>() - 1000) < 1e-9);
  CHECK(shifted.at("steps") == plain.at("steps"));
  for (const char* error : {"position.horizontal", "velocity.horizontal", "attitude.yaw"}) {
    CHECK(figure(shifted, error, "n") == figure(plain, error, "n"));
    CHECK(std::abs(figure(shifted, error) - figure(plain, error)) < 1e-9);
  }

  std::vector<std::string> window;
  for (const auto& source : sources) window.push_back("/sources/" + source + R"(/window=["0 s", "200 s"])");
  const ordered_json part = run_drive(*folder, config, window).at("filters").at("ins");
  check_ledger(part, 400);  // 2 Hz, from 0.304 s to 199.804 s
  CHECK(part.at("end_s").get<double>() <= 200);
  CHECK(part.at("end_s").get<double>() > 199.98);
}

}  // namespace drives_test
