// SPDX-License-Identifier: Apache-2.0
// The configs of configs/smartloc on recorded pseudoranges of a street canyon: figures that must be reached.
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Dense>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "score/run.hpp"
#include "strapdown/earth.hpp"
#include "text/text_file.hpp"

namespace smartloc_test {

using namespace binnacle;
using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

ordered_json car(const std::filesystem::path& data, const std::string& config, std::vector<std::string> sets = {}) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  load.vars["smartloc"] = data.string();
  load.sets = std::move(sets);
  const auto result = score::run(score::load(BINNACLE_TEST_PROJECT "/configs/smartloc/" + config + ".json", load));
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  return result.summary.at("filters").at("car");
}

ordered_json horizontal(const std::filesystem::path& data, const std::string& config) {
  const ordered_json filter = car(data, config);
  // No epoch is dropped.
  CHECK(filter.at("measurements").at("ranges").at("accepted") == 1372);
  return filter.at("reference").at("position.horizontal");
}

/// The lines of a kind at time 0, as numbers from the third column on.
std::vector<std::vector<double>> first_epoch(const std::filesystem::path& file, const std::string& kind) {
  text_file::LineReader reader(file.string());
  std::vector<std::vector<double>> rows;
  for (std::string_view line; reader.next(line);) {
    std::istringstream cells{std::string(line)};
    std::string tag, time;
    cells >> tag >> time;
    if (tag != kind || time != "0") continue;
    rows.emplace_back();
    for (double number; cells >> number;) rows.back().push_back(number);
  }
  return rows;
}

/// Weighted least squares of an epoch, by Gauss and Newton, with none of the code under test: x, y, z, clock, GLONASS's
/// offset. The earth's turn by the formula of Sagnac, σ as the config says, of elevations at `start`, where the filter has them
/// from: 1 km turns a satellite that is 2 deg high by a thousandth of its sine.
Vector3d least_squares(const std::vector<std::vector<double>>& rows, const Vector3d& start) {
  const Vector3d lla = strapdown::lla_from_ecef(start);
  const Vector3d up = -strapdown::C_en(lla[0], lla[1]).col(2);
  Vector3d r = start;
  Eigen::Vector2d clocks = Eigen::Vector2d::Zero();
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix<double, 5, 5> N = Eigen::Matrix<double, 5, 5>::Zero();
    Eigen::Matrix<double, 5, 1> b = Eigen::Matrix<double, 5, 1>::Zero();
    for (const auto& row : rows) {  // pseudorange, its variance, satellite's x, y, z, number, system, elevation, C/N0
      const Vector3d s(row[2], row[3], row[4]), u = (s - r).normalized();
      const double turn = 7.2921151467e-5 / 299792458.0 * (s.x() * r.y() - s.y() * r.x());
      const bool is_glonass = row[6] == 4;
      const double sine = (s - start).normalized().dot(up);
      const double variance = 4 + 25 / (sine * sine) + 100 * std::pow(10, (40 - row[8]) / 10);
      Eigen::Matrix<double, 5, 1> a;
      a << -u, 1, is_glonass ? 1 : 0;
      const double residual = row[0] - ((s - r).norm() + turn + clocks[0] + (is_glonass ? clocks[1] : 0));
      N += a * a.transpose() / variance;
      b += a * residual / variance;
    }
    const Eigen::Matrix<double, 5, 1> step = N.ldlt().solve(b);
    r += step.head<3>();
    clocks += step.tail<2>();
  }
  return r;
}

}  // namespace

TEST_CASE("smartLoc: a filter that knows nothing is the least-squares solution of its first epoch", "[data]") {
  const auto data = binnacle::test::recorded_data("smartloc");
  if (!data) return;
  const auto rows = first_epoch(*data / "potsdamer_platz_input.txt.gz", "pseudorange3");
  const auto truth = first_epoch(*data / "potsdamer_platz_truth.txt.gz", "point3");
  REQUIRE(rows.size() >= 8);
  REQUIRE(truth.size() == 1);
  const Vector3d r(truth[0][0], truth[0][1], truth[0][2]), lla = strapdown::lla_from_ecef(r);
  const double degree = M_PI / 180;
  const Vector3d start = strapdown::ecef_from_lla({52.51 * degree, 13.37 * degree, 100});
  const Vector3d expected = strapdown::position_minus(lla, strapdown::lla_from_ecef(least_squares(rows, start)));
  const std::string blocks = "/filters/car/blocks/";
  const ordered_json filter =
      car(*data, "alone",
          {R"(/sources/ranges/window=["-1 s", "0.1 s"])", R"(/sources/track/window=["-1 s", "0.1 s"])",
           "/evaluate/windows=null", blocks + R"(position/sigma="100 km")", blocks + R"(glonass/sigma="100 km")",
           R"(/filters/car/measurements/ranges/update={"type": "iterated", "max": 20, "tolerance": 1e-6})"});
  const auto& errors = filter.at("reference");
  const char* const names[] = {"position.north", "position.east", "position.down"};
  for (int i = 0; i < 3; ++i) {
    INFO(names[i]);
    CHECK(errors.at(names[i]).at("n") == 1);
    CHECK(std::abs(errors.at(names[i]).at("final").get<double>() - expected[i]) < 0.01);
  }
  CHECK(expected.norm() > 5);  // a street canyon
}

TEST_CASE("smartLoc: a car in a street canyon, without odometry and with it", "[data]") {
  const auto data = binnacle::test::recorded_data("smartloc");
  if (!data) return;
  const auto alone = horizontal(*data, "alone"), odometry = horizontal(*data, "odometry");
  CHECK(alone.at("n") == 1372);
  CHECK(odometry.at("n") == 1372);
  CHECK(alone.at("rms").get<double>() <= 27.0);
  CHECK(odometry.at("rms").get<double>() <= 28.0);
  CHECK(odometry.at("rms").get<double>() < alone.at("rms").get<double>());
}

}  // namespace smartloc_test
