// SPDX-License-Identifier: Apache-2.0
// The configs of configs/gnss and configs/ins_gps on recorded data: figures that must be reached, and that what is
// broken is survived. Data as in gnss_data.hpp.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "catch.hpp"
#include "gnss_data.hpp"
#include "score/run.hpp"
#include "strapdown/earth.hpp"

namespace recorded_test {

using namespace binnacle;
using namespace binnacle::test;
using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

score::RunResult run_config(const std::filesystem::path& data, const std::string& config, std::vector<std::string> sets,
                            score::RunObserver* observer = nullptr) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  load.vars["gnss"] = data.string();
  load.sets = std::move(sets);
  score::RunOptions options;
  options.observer = observer;
  score::RunResult result =
      score::run(score::load(BINNACLE_TEST_PROJECT "/configs/" + config + ".json", load), options);
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  return result;
}

struct Static {
  double rms = 0, median = 0;
  int scored = 0;
};

/// Errors in three dimensions against the surveyed place, or against another channel.
Static static_errors(const std::filesystem::path& data, const std::string& config, std::vector<std::string> sets = {}) {
  const ordered_json summary = run_config(data, "gnss/" + config, std::move(sets)).summary;
  const auto& distance = summary.at("filters").at("gps").at("reference").at("position.distance");
  return {distance.at("rms").get<double>(), distance.at("p50").get<double>(), distance.at("n").get<int>()};
}

/// A copy of a recorded file, changed; removed at the end.
class Changed {
 public:
  Changed(const std::filesystem::path& original, const std::function<std::string(std::string)>& change)
      : path_(std::filesystem::temp_directory_path() /
              ("binnacle_" + std::to_string(::getpid()) + "_" + original.filename().string())) {
    std::ifstream in(original, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    std::ofstream(path_, std::ios::binary) << change(std::move(text));
  }
  ~Changed() { std::filesystem::remove(path_); }
  Changed(const Changed&) = delete;
  Changed& operator=(const Changed&) = delete;
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// What the car's filter says just after each whole second.
class Seconds final : public score::RunObserver {
 public:
  void begin(int, const std::string&, const std::vector<score::RecordColumn>& columns) override {
    for (std::size_t i = 0; i < columns.size(); ++i) column_[columns[i].name] = i;
  }
  void record(int, Time t, std::span<const double> values) override {
    const auto value = [&](const char* name) { return values[column_.at(name)]; };
    const State state{seconds(t),
                      {value("position.lat"), value("position.lon"), value("position.height")},
                      {value("velocity.vn"), value("velocity.ve"), value("velocity.vd")}};
    yaw = value("attitude.yaw") * 180 / M_PI;
    // The first record after a second has its update in it; a record at the second itself may not.
    const auto second = static_cast<int>(std::floor(state.t - 5e-4));
    after_.try_emplace(second, state);
  }
  bool has(int second) const { return after_.count(second) > 0; }
  /// ECEF, taken back to the second by the velocity: some milliseconds.
  Vector3d position(int second) const {
    const State& state = after_.at(second);
    return strapdown::ecef_from_lla(strapdown::position_plus(state.lla, (second - state.t) * state.v));
  }
  Vector3d velocity(int second) const { return after_.at(second).v; }

  double yaw = 0;  // the last, deg

 private:
  struct State {
    double t;
    Vector3d lla, v;
  };
  std::map<std::string, std::size_t> column_;
  std::map<int, State> after_;
};

constexpr int first_driving = 185562;  // s of week: 70 s after the record's begin
constexpr double record_begin = 185492.5;

class Trajectory {
 public:
  explicit Trajectory(const std::filesystem::path& data) {
    for (auto& row : table(data / "tightly_coupled_psins" / "ref_tdcp.csv"))
      at_[std::stoi(row.at("gps_sow"))] = {std::stod(row.at("x_ecef_m")), std::stod(row.at("y")),
                                           std::stod(row.at("z"))};
    const Vector3d lla = strapdown::lla_from_ecef(at_.at(first_driving));
    C_ne_ = strapdown::C_en(lla[0], lla[1]).transpose();
  }
  /// Differences from it in north, east, down while driving.
  std::map<int, Vector3d> differences(const Seconds& estimate) const {
    std::map<int, Vector3d> list;
    for (const auto& [t, r] : at_)
      if (t >= first_driving && estimate.has(t)) list[t] = C_ne_ * (estimate.position(t) - r);
    return list;
  }
  static Vector3d mean(const std::map<int, Vector3d>& list) {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [t, d] : list) sum += d;
    return sum / static_cast<double>(list.size());
  }
  /// Against its central differences.
  std::vector<Vector3d> velocity_errors(const Seconds& estimate) const {
    std::vector<Vector3d> list;
    for (const auto& [t, r] : at_)
      if (t >= first_driving && estimate.has(t) && at_.count(t - 1) && at_.count(t + 1))
        list.push_back(estimate.velocity(t) - C_ne_ * (at_.at(t + 1) - at_.at(t - 1)) / 2);
    return list;
  }

 private:
  std::map<int, Vector3d> at_;
  Eigen::Matrix3d C_ne_;
};

struct DrivingScore {
  double horizontal = 0, distance = 0, largest = 0, velocity = 0, velocity_horizontal = 0, yaw = 0;
  Vector3d offset;
};

Seconds drive(const std::filesystem::path& data, std::vector<std::string> sets) {
  Seconds estimate;
  sets.push_back("/record/every=0.004 s");
  run_config(data, "ins_gps/recorded", std::move(sets), &estimate);
  return estimate;
}

DrivingScore judge(const Trajectory& trajectory, const Seconds& estimate) {
  DrivingScore d;
  const auto differences = trajectory.differences(estimate);
  REQUIRE(differences.size() >= 66);
  d.offset = Trajectory::mean(differences);
  for (const auto& [t, difference] : differences) {
    const Vector3d e = difference - d.offset;
    d.horizontal += e.head<2>().squaredNorm() / static_cast<double>(differences.size());
    d.distance += e.squaredNorm() / static_cast<double>(differences.size());
    d.largest = std::max(d.largest, e.norm());
  }
  const auto velocities = trajectory.velocity_errors(estimate);
  for (const Vector3d& v : velocities) {
    d.velocity += v.squaredNorm() / static_cast<double>(velocities.size());
    d.velocity_horizontal += v.head<2>().squaredNorm() / static_cast<double>(velocities.size());
  }
  for (double* square : {&d.horizontal, &d.distance, &d.velocity, &d.velocity_horizontal}) *square = std::sqrt(*square);
  d.yaw = estimate.yaw;
  return d;
}

/// RMS over the five cuts of the horizontal error at the last whole second of each.
double cut_error(const std::filesystem::path& data, const Trajectory& trajectory, int satellites,
                 const Vector3d& offset) {
  double sum = 0;
  for (const double start : {82.0, 90.0, 98.0, 106.0, 115.0}) {
    const double from = record_begin + start, to = from + 20;
    const std::string cuts = R"([{"from": ")" + std::to_string(from) + R"( s", "to": ")" + std::to_string(to) +
                             R"( s", "satellites": )" + std::to_string(satellites) + "}]";
    const Seconds estimate =
        drive(data, {"/filters/ins/measurements/ranges/cuts=" + cuts, "/filters/ins/measurements/rates/cuts=" + cuts});
    const Vector3d e = trajectory.differences(estimate).at(static_cast<int>(std::floor(to))) - offset;
    sum += e.head<2>().squaredNorm() / 5;
  }
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("GPS alone on recorded observations") {
  const auto data = gnss_data();
  if (!data) return;
  const auto report = [](const char* what, const Static& s, double most) {
    std::printf("%-36s %3d epochs, 3D RMS %.3f m (%.2f)\n", what, s.scored, s.rms, most);
    CHECK(s.rms <= most);
  };
  const Static low = static_errors(*data, "0759"), high = static_errors(*data, "0759_mask15"),
               sept = static_errors(*data, "sept"), nearest = static_errors(*data, "sept_nearest_toe");
  report("0759, 10 deg", low, 1.9);
  CHECK(low.scored == 120);
  report("0759, 15 deg", high, 2.0);
  CHECK(high.scored == 114);
  report("SEPT, messages by upload time", sept, 1.15);
  CHECK(sept.scored == 900);
  report("SEPT, messages by nearest toe", nearest, 1.7);
  CHECK(nearest.scored == 900);

  const std::string peer = R"(/sources/peer={"type": "csv", "path": ")" +
                           (*data / "peer_rtklib" / "0759.pos.gz").string() +
                           R"(", "delimiter": " ", "comment": "%", "header": false, "time": {"column": "2"},
          "columns": {"x": {"column": "3", "unit": "m"}, "y": {"column": "4", "unit": "m"}, "z": {"column": "5", "unit": "m"}}})";
  // RTKLIB maps the troposphere by 1/sin(elevation).
  const Static from_peer =
      static_errors(*data, "0759_mask15",
                    {"/filters/gps/measurements/ranges/troposphere_mapping=cosecant",
                     "/transforms/single_point/troposphere_mapping=cosecant", peer,
                     R"(/reference=[{"channel": "peer", "blocks": {"gps/position": ["x", "y", "z"]}}])"});
  std::printf("%-36s %3d epochs, median %.3f m (0.60)\n", "0759, 15 deg, from the peer", from_peer.scored,
              from_peer.median);
  CHECK(from_peer.median <= 0.6);
}

TEST_CASE("Galileo alone and with GPS on recorded observations") {
  const auto data = gnss_data();
  if (!data) return;
  const Static alone = static_errors(*data, "sept", {"/sources/gnss/signals/galileo=1C", "/sources/gnss/signals/gps="});
  const Static both =
      static_errors(*data, "sept",
                    {"/sources/gnss/signals/galileo=1C",
                     R"(/filters/gps/blocks/galileo={"type": "vector", "size": 1, "unit": "m", "sigma": "30 m"})",
                     R"(/filters/gps/process/galileo={"type": "random_constant", "blocks": {"x": "galileo"}})",
                     "/filters/gps/measurements/ranges/blocks/system_offset=galileo"});
  std::printf("SEPT, Galileo alone: 3D RMS %.3f m; with GPS: %.3f m\n", alone.rms, both.rms);
  CHECK(alone.scored == 900);
  CHECK(alone.rms < 2);
  CHECK(both.rms < 1.6);
}

TEST_CASE("single-point solutions of recorded observations") {
  const auto data = gnss_data();
  if (!data) return;
  // The filter is made to forget, so that each of its estimates is the epoch's own: the same within centimetres.
  for (const auto& [config, most] : {std::pair{"0759", 1.9}, std::pair{"sept", 1.15}}) {
    const Static alone =
        static_errors(*data, config, {"/filters/gps/process/motion/S_v=1e6", "/filters/gps/process/clock/S_f=1e6"});
    std::printf("%s, every epoch by itself: 3D RMS %.3f m\n", config, alone.rms);
    CHECK(alone.rms <= 1.1 * most);
  }
}

TEST_CASE("tightly coupled on a recorded car") {
  const auto data = gnss_data();
  if (!data) return;
  const Trajectory trajectory(*data);
  const DrivingScore d = judge(trajectory, drive(*data, {}));
  std::printf(
      "driving: horizontal %.3f m (0.27), 3D %.3f (0.40), max %.3f (1.0), velocity %.3f m/s, horizontal %.3f (0.13), "
      "final heading %.2f deg\n",
      d.horizontal, d.distance, d.largest, d.velocity, d.velocity_horizontal, d.yaw);
  CHECK(d.horizontal <= 0.27);
  CHECK(d.distance <= 0.40);
  CHECK(d.largest <= 1.0);
  CHECK(d.velocity_horizontal <= 0.13);
  CHECK(std::abs(d.yaw - 2.2) <= 0.5);

  for (const auto& [satellites, most] : {std::pair{3, 0.9}, std::pair{2, 1.9}, std::pair{0, 2.6}}) {
    const double error = cut_error(*data, trajectory, satellites, d.offset);
    std::printf("20 s with %d satellites: %.2f m RMS at the end (%.1f)\n", satellites, error, most);
    CHECK(error <= most);
  }

  const DrivingScore late = judge(trajectory, drive(*data, {"/sources/imu/time/offset=0 s"}));
  std::printf("IMU labels taken as they are: horizontal %.3f m, velocity %.3f m/s, horizontal %.3f\n", late.horizontal,
              late.velocity, late.velocity_horizontal);
  CHECK(late.velocity > 1.35 * d.velocity);
  CHECK(late.horizontal > 1.2 * d.horizontal);
}

TEST_CASE("broken recordings are reported and survived") {
  const auto data = gnss_data();
  if (!data) return;
  const auto rinex = *data / "rinex";
  const double undisturbed = static_errors(*data, "0759").rms;
  const auto run_with = [&](const char* key, const Changed& file) {
    const score::RunResult result =
        run_config(*data, "gnss/0759", {std::string("/sources/gnss/") + key + "=" + file.path()});
    const auto& distance = result.summary.at("filters").at("gps").at("reference").at("position.distance");
    CHECK(distance.at("rms").get<double>() < 1.7 * undisturbed);
    return std::pair{distance.at("n").get<int>(), result.warnings.text()};
  };
  const auto says = [](const std::string& text, const char* what) { return text.find(what) != std::string::npos; };
  {
    const Changed cut(rinex / "07590920.05o", [](std::string text) { return text.substr(0, text.size() / 2 + 17); });
    const auto [scored, warnings] = run_with("observations", cut);
    CHECK((scored > 55 && scored < 65));
    CHECK(says(warnings, "B061"));
  }
  {
    const Changed swapped(rinex / "07590920.05o", [](std::string text) {
      const auto at = text.find(" 05  4  2  0 10  0.0");
      return text.replace(at, 15, " 05  4  2  0  9");
    });
    const auto [scored, warnings] = run_with("observations", swapped);
    CHECK(scored == 119);
    CHECK(says(warnings, "B063"));
  }
  {
    // G11's messages are gone: the filter does without it, and the source says for how long.
    const Changed fewer(rinex / "07590920.05n", [](std::string text) {
      for (std::size_t at; (at = text.find("\n11 05")) != std::string::npos;) {
        std::size_t end = at + 1;
        for (int i = 0; i < 8; ++i) end = text.find('\n', end) + 1;
        text.erase(at + 1, end - at - 1);
      }
      return text;
    });
    const auto [scored, warnings] = run_with("navigation", fewer);
    CHECK(scored == 120);
    CHECK(says(warnings, "G11 (120 epochs)"));
  }
}

TEST_CASE("a receiver clock that jumps by a millisecond is recovered from") {
  const auto data = gnss_data();
  if (!data) return;
  // From 00:30 on a millisecond more in every pseudorange (of C1, the second column), and in no phase.
  const Changed jumped(*data / "rinex" / "07590920.05o", [](std::string text) {
    std::size_t at = text.find(" 05  4  2  0 30  0.0");
    char number[16];
    while ((at = text.find('\n', at)) != std::string::npos && at + 1 < text.size()) {
      ++at;
      if (text.compare(at, 6, " 05  4") == 0 || text.find('\n', at) - at < 30 || text[at + 26] != '.') continue;
      const double range = std::stod(text.substr(at + 16, 14)) + 299792.458;
      std::snprintf(number, sizeof number, "%14.3f", range);
      text.replace(at + 16, 14, number);
    }
    return text;
  });
  const std::vector<std::string> file{"/sources/gnss/observations=" + jumped.path()};
  const score::RunResult recovered = run_config(*data, "gnss/0759", file);
  const auto& gps = recovered.summary.at("filters").at("gps");
  CHECK(recovered.warnings.text().find("the receiver's clock jumps 1 time") != std::string::npos);
  CHECK(gps.at("measurements").at("ranges").at("gated").get<int>() == 3);
  CHECK(gps.at("measurements").at("ranges").at("accepted").get<int>() == 116);
  CHECK(gps.at("reference").at("position.distance").at("rms").get<double>() < 1.25 * static_errors(*data, "0759").rms);
  // Without it the clock's own wandering opens the filter again, after more epochs.
  auto without = file;
  without.push_back("/filters/gps/measurements/ranges/recover/after=1000000");
  const auto locked =
      run_config(*data, "gnss/0759", without).summary.at("filters").at("gps").at("measurements").at("ranges");
  CHECK(locked.at("gated").get<int>() > 3);
}

TEST_CASE("a satellite that is 1 km wrong for twenty minutes is left out, reported and survived") {
  const auto data = gnss_data();
  if (!data) return;
  int changed = 0;
  const Changed faulty(*data / "rinex" / "07590920.05o", [&](const std::string& text) {
    std::istringstream in(text);
    std::ostringstream out;
    std::vector<std::string> satellites;
    std::size_t row = 0;
    bool is_data = false, is_time = false;
    for (std::string line; std::getline(in, line); out << line << '\n') {
      if (!is_data) {
        is_data = line.find("END OF HEADER") != std::string::npos;
      } else if (line.compare(0, 6, " 05  4") == 0) {
        const int minute = std::stoi(line.substr(13, 2)), count = std::stoi(line.substr(29, 3));
        is_time = std::stoi(line.substr(10, 2)) == 0 && minute >= 20 && minute < 40;
        satellites.clear();
        row = 0;
        for (int i = 0; i < count; ++i) satellites.push_back(line.substr(33 + 3 * static_cast<std::size_t>(i), 2));
      } else if (row < satellites.size() && satellites[row++] == "11" && is_time && line.size() >= 30) {
        char number[16];
        std::snprintf(number, sizeof number, "%14.3f", std::stod(line.substr(16, 14)) + 1000);
        line.replace(16, 14, number);
        ++changed;
      }
    }
    return out.str();
  });
  REQUIRE(changed == 40);
  const score::RunResult result = run_config(*data, "gnss/0759", {"/sources/gnss/observations=" + faulty.path()});
  const auto& gps = result.summary.at("filters").at("gps");
  const auto& ranges = gps.at("measurements").at("ranges");
  INFO(ranges.dump());
  CHECK(ranges.at("accepted") == 119);
  CHECK(ranges.at("left_out").at("by_key") == nlohmann::ordered_json({{"111", 40}}));
  CHECK(gps.at("reference").at("position.distance").at("rms").get<double>() < 1.25 * static_errors(*data, "0759").rms);
}

}  // namespace recorded_test
