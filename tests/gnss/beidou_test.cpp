// SPDX-License-Identifier: Apache-2.0
// BeiDou: messages, orbits, clocks and observations against files of beidou.py, which was written from the interface document
// by itself, and RTKLIB's solutions of them.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "../plugins/bind.hpp"
#include "../readers/reading.hpp"
#include "catch.hpp"
#include "gnss/gps_time.hpp"
#include "gnss_data.hpp"
#include "rinex/navigation_file.hpp"
#include "rinex/observation_file.hpp"
#include "rinex/rinex_source.hpp"
#include "score/run.hpp"

namespace beidou_test {

using namespace binnacle;
using namespace binnacle::gnss;
using Eigen::Vector3d;

namespace {

constexpr int week = 2183;
constexpr double first_epoch = 2 * 86400 + 3.5 * 3600;  // s of the week

/// What beidou.py says of a satellite at the first epoch.
struct Expected {
  Vector3d position, velocity;
  double clock;
};

struct Site {
  test::Folder folder;
  std::map<SatelliteKey, Expected> expected;

  Site() {
    const std::string command =
        std::string(BINNACLE_TEST_PYTHON " " BINNACLE_TEST_PROJECT "/tests/gnss/beidou.py '") + folder.file("") + "'";
    FILE* const pipe = ::popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    char name[8];
    Expected e;
    double up = 0;
    while (std::fscanf(pipe, "%7s %lf %lf %lf %lf %lf %lf %lf %lf", name, &e.position[0], &e.position[1],
                       &e.position[2], &e.velocity[0], &e.velocity[1], &e.velocity[2], &e.clock, &up) == 9)
      expected[parse_satellite(name).value()] = e;
    REQUIRE(::pclose(pipe) == 0);
  }
  rinex::Navigation navigation() const {
    test::Reports reports;
    const std::string path = folder.file("site.nav");
    rinex::Faults faults(path, rinex::OnInvalid::skip, reports);
    auto read = rinex::read_navigation(path, week, faults);
    faults.report();
    CHECK(reports.all.empty());
    return read;
  }
  std::vector<rinex::Epoch> observations(const Signals& signals) const {
    test::Reports reports;
    const std::string path = folder.file("site.obs");
    rinex::Faults faults(path, rinex::OnInvalid::skip, reports);
    auto read = rinex::read_observations(path, week, signals, faults);
    faults.report();
    CHECK(reports.all.empty());
    return read;
  }
};

/// 3D RMS of configs/gnss's filter on the files, and its distance from single_point.
std::pair<double, double> errors(const Site& site, std::vector<std::string> sets) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  for (const auto& set :
       {"/sources/gnss/observations=" + site.folder.file("site.obs"),
        "/sources/gnss/navigation=" + site.folder.file("site.nav"), std::string("/sources/gnss/week=2183"),
        std::string("/transforms/single_point/ionosphere=none"),
        std::string("/transforms/single_point/troposphere=none"),
        std::string("/filters/gps/measurements/ranges/ionosphere=none"),
        std::string("/filters/gps/measurements/ranges/troposphere=none")})
    sets.push_back(set);
  const auto distance = [&](const std::vector<std::string>& more) {
    LoadOptions load;
    load.sets = sets;
    load.sets.insert(load.sets.end(), more.begin(), more.end());
    const auto result = score::run(score::load(BINNACLE_TEST_PROJECT "/configs/gnss/sept.json", load), {});
    INFO(result.failures.text());
    CHECK(result.failures.empty());
    const auto& score = result.summary.at("filters").at("gps").at("reference").at("position.distance");
    CHECK(score.at("n").get<int>() == 20);
    return score.at("max").get<double>();
  };
  return {distance({}),
          distance({R"(/reference=[{"channel": "single_point", "blocks": {"gps/position": ["x", "y", "z"]}}])"})};
}

}  // namespace

TEST_CASE("BeiDou's orbits and clocks equal an implementation of their own: MEO, IGSO and GEO") {
  const Site site;
  REQUIRE(site.expected.size() == 17);
  const Time t = nanoseconds(first_epoch);
  double position = 0, velocity = 0, clock = 0;
  std::size_t seen = 0;
  for (const auto& message : site.navigation().messages) {
    const Ephemeris& e = message.ephemeris;
    const Expected& expected = site.expected.at(e.satellite);
    INFO(satellite_name(e.satellite));
    const SatelliteState state = satellite_state(e, t);
    CHECK((state.position - expected.position).norm() < 1e-3);
    CHECK((state.velocity - expected.velocity).norm() < 1e-4);
    CHECK(std::abs(state.clock - expected.clock) * speed_of_light < 1e-4);
    CHECK(std::abs(satellite_clock(e, t, 0) - state.clock) < 1e-18);
    position = std::max(position, (state.position - expected.position).norm());
    velocity = std::max(velocity, (state.velocity - expected.velocity).norm());
    clock = std::max(clock, std::abs(state.clock - expected.clock) * speed_of_light);
    const Vector3d slope = (satellite_state(e, t, -0.5).position - satellite_state(e, t, 0.5).position);
    CHECK((slope - state.velocity).norm() < 1e-5);
    ++seen;
    // Its own time: 14 s behind.
    const bool is_beidou = constellation_of(e.satellite) == Constellation::beidou;
    CHECK(std::fmod(e.toe, 60) == (is_beidou ? gps_minus_beidou : 0));
    CHECK(e.toc == e.toe);
    CHECK(std::abs(std::abs(e.group_delay) - 5e-9) < 1e-18);  // TGD1, not TGD2
  }
  CHECK(seen == site.expected.size());
  std::printf("BeiDou: position %.1e m, velocity %.1e m/s, clock %.1e m at most from python's\n", position, velocity,
              clock);
}

TEST_CASE("BeiDou's observations: rows where they are asked for, range rates by the wavelength of B1I") {
  const Site site;
  Signals signals{"1C", "", "2I"};
  const auto epochs = site.observations(signals);
  REQUIRE(epochs.size() == 20);
  int compared = 0;
  for (std::size_t k = 1; k + 1 < epochs.size(); ++k)
    for (std::size_t i = 0; i < epochs[k].satellites.size(); ++i) {
      const auto& now = epochs[k].satellites[i];
      const double slope = (epochs[k + 1].satellites[i].pseudorange - epochs[k - 1].satellites[i].pseudorange) / 2;
      CHECK(std::abs(now.range_rate - slope) < 0.01);
      compared += constellation_of(now.satellite) == Constellation::beidou;
    }
  CHECK(compared == 18 * 9);
  CHECK(epochs[0].satellites.front().satellite == 301);
  signals.beidou = "";
  CHECK(site.observations(signals)[0].satellites.size() == 5);
  for (const char* code : {"1X", "1C", "5P"})
    CHECK_THROWS_AS(test::bind<rinex::RinexSource>(
                        {{{"observations", site.folder.file("site.obs")}, {"signals", {{"beidou", code}}}}, {}, {}}),
                    ComponentError);
}

TEST_CASE("the time of an observation file may be BeiDou's") {
  const Site site;
  std::ifstream in(site.folder.file("site.obs"));
  std::string text((std::istreambuf_iterator<char>(in)), {});
  text.replace(text.find("     GPS         TIME OF FIRST"), 8, "     BDT");
  std::ofstream(site.folder.file("site.obs")) << text;
  const auto epochs = site.observations({"", "", "2I"});
  CHECK(seconds(epochs.at(0).t) == first_epoch + gps_minus_beidou);
}

TEST_CASE("a receiver is found by BeiDou, alone and with GPS, and RTKLIB finds it there") {
  const Site site;
  const std::string beidou = "/sources/gnss/signals/beidou=2I";
  const auto [alone, point] = errors(site, {beidou, "/sources/gnss/signals/gps="});
  const auto [both, of_both] =
      errors(site, {beidou, R"(/filters/gps/blocks/more={"type": "vector", "size": 1, "unit": "m", "sigma": "1 km"})",
                    R"(/filters/gps/process/more={"type": "random_constant", "blocks": {"x": "more"}})",
                    "/filters/gps/measurements/ranges/blocks/system_offset=more",
                    "/filters/gps/measurements/ranges/systems=[1, 3]"});
  std::printf("BeiDou alone: %.4f m, from single_point %.4f m; with GPS %.4f m, %.4f m\n", alone, point, both, of_both);
  for (const double error : {alone, point, both, of_both}) CHECK(error < 0.005);  // numbers of the file: 1 mm

  if (std::system("command -v rnx2rtkp > /dev/null 2>&1") != 0) return test::skip("no rnx2rtkp (package rtklib)");
  std::ofstream(site.folder.file("c.conf"))
      << "pos1-posmode=single\npos1-elmask=10\npos1-ionoopt=off\npos1-tropopt=off\npos1-navsys=32\n"
         "out-solformat=xyz\nout-timeform=tow\n";
  REQUIRE(
      std::system(("cd '" + site.folder.file("") + "' && rnx2rtkp -k c.conf -o c.pos site.obs site.nav 2> /dev/null")
                      .c_str()) == 0);
  std::ifstream in(site.folder.file("c.pos"));
  int solutions = 0;
  double most = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '%') continue;
    std::istringstream words(line);
    double number_of_week = 0, tow = 0;
    Vector3d r;
    words >> number_of_week >> tow >> r[0] >> r[1] >> r[2];
    most = std::max(most, (r - Vector3d(-3962108.673, 3381309.574, 3668678.638)).norm());
    ++solutions;
  }
  CHECK(solutions == 20);
  CHECK(most < 0.01);
  std::printf("BeiDou alone, by RTKLIB: %.4f m\n", most);
}

}  // namespace beidou_test
