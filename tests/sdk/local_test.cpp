// SPDX-License-Identifier: Apache-2.0
// "origin" of a config: what is recorded with one, and the errors of one that is missing or wrong.
#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "csv_columns.hpp"
#include "results/results.hpp"

namespace local_test {

using namespace binnacle::test;
using binnacle::results::FilterResults;
using binnacle::test::Contains;

namespace {

const std::string quickstart = BINNACLE_TEST_PROJECT "/configs/quickstart.json";
const std::string origin = R"(/origin={"lat": "48.13 deg", "lon": "11.58 deg", "height": "500 m"})";

struct Point {
  double x, y, z;
};

/// WGS 84, written out once more.
Point ecef(double lat, double lon, double height) {
  const double a = 6378137.0, e2 = 6.69437999014131e-3, N = a / std::sqrt(1 - e2 * std::pow(std::sin(lat), 2));
  return {(N + height) * std::cos(lat) * std::cos(lon), (N + height) * std::cos(lat) * std::sin(lon),
          (N * (1 - e2) + height) * std::sin(lat)};
}

const std::vector<double>& column(const FilterResults& filter, const std::string& name) {
  for (const auto& other : filter.others)
    if (other.name + "[" + other.unit + "]" == name) return other.values;
  for (const auto& estimate : filter.estimates)
    if (estimate.block + "." + estimate.output + "[" + estimate.unit + "]" == name) return estimate.values;
  FAIL("there is no column " + name);
  return filter.t;
}

/// By run.nc: the CSV has not the digits.
void check_local(const FilterResults& filter) {
  const double degree = M_PI / 180, lat = 48.13 * degree, lon = 11.58 * degree;
  const Point from = ecef(lat, lon, 500);
  const auto &north = column(filter, "position.local_north[m]"), &east = column(filter, "position.local_east[m]"),
             &down = column(filter, "position.local_down[m]");
  REQUIRE(north.size() > 10);
  for (std::size_t i = 0; i < north.size(); ++i) {
    const Point at = ecef(column(filter, "position.lat[rad]")[i], column(filter, "position.lon[rad]")[i],
                          column(filter, "position.height[m]")[i]);
    const double x = at.x - from.x, y = at.y - from.y, z = at.z - from.z;
    const double outward = x * std::cos(lon) + y * std::sin(lon);  // from the earth's axis
    REQUIRE(std::abs(east[i] - (y * std::cos(lon) - x * std::sin(lon))) < 1e-6);
    REQUIRE(std::abs(north[i] - (z * std::cos(lat) - outward * std::sin(lat))) < 1e-6);
    REQUIRE(std::abs(down[i] - (-z * std::sin(lat) - outward * std::cos(lat))) < 1e-6);
  }
}

}  // namespace

TEST_CASE("with an origin records have local north, east and down, and the figures stay the same") {
  const Workbench bench;
  const auto plain = binnacle::test::binnacle(bench, {"run", quickstart, "--json"});
  const auto local = binnacle::test::binnacle(bench, {"run", quickstart, "--json", "--smooth", "--out", "out", "--set",
                                                      origin, "--set", "/record/every=1 s"});
  INFO(local.err);
  REQUIRE(plain.status == 0);
  REQUIRE(local.status == 0);
  const auto figures = [](const Outcome& outcome) {
    return nlohmann::json::parse(outcome.out).at("filters").at("ins").at("reference");
  };
  CHECK(figures(plain) == figures(local));
  const auto filters = binnacle::results::read(bench.path("out")).run->filters;
  REQUIRE(filters.size() == 2);
  for (const auto& filter : filters) check_local(filter);
  for (const char* name : {"out/ins.csv", "out/ins.smoothed.csv"}) {
    const auto names = read_csv(bench.path(name)).names;
    CHECK(std::ranges::count(names, "position.local_north[m]") == 1);
  }
}

TEST_CASE("an origin that is missing or wrong is an error that says where") {
  const Workbench bench;
  const auto said = [&](const std::vector<std::string>& settings) {
    std::vector<std::string> arguments{"check", quickstart};
    for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
    const auto outcome = binnacle::test::binnacle(bench, arguments);
    CHECK(outcome.status == 3);
    return outcome.err;
  };
  const std::string transform = R"(/transforms/local={"type": "local_from_geodetic", "input": "drive.truth"})";
  CHECK_THAT(said({transform}),
             Contains("/transforms/local: local coordinates need an origin") && Contains("(/origin)"));
  CHECK_THAT(said({R"(/origin={"lat": "37 deg", "lon": "127 deg"})"}),
             Contains("error[B010] /origin: missing key 'height' of 'origin': above the ellipsoid (m)"));
  CHECK_THAT(said({transform, R"(/origin={"lat": "37 m", "lon": "127 deg", "height": 3})"}),
             Contains("error[B007] /origin/lat: '37 m' is a length; 'lat' is an angle") &&
                 Contains(
                     "error[B010] /transforms/local: 'origin' of 'local_from_geodetic' is that of the config, in which "
                     "something is wrong (/origin)"));
  CHECK_THAT(said({R"(/orgin={"lat": 0, "lon": 0, "height": 3})"}), Contains("did you mean 'origin'?"));
}

}  // namespace local_test
