// SPDX-License-Identifier: Apache-2.0
// Plugin constellation_simulator: geometry against the inertial frame, rates against differences, errors against their
// statistics, masks, cuts, faults and jumps.
#include "../../plugins/constellation_simulator/constellation_simulator.hpp"
#include "binnacle/testing.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "../../plugins/constellation_simulator/constellation.hpp"
#include "bind.hpp"
#include "binnacle/view.hpp"
#include "catch.hpp"
#include "gnss/channels.hpp"
#include "strapdown/earth.hpp"

namespace constellation_simulator_test {

using namespace binnacle;
using namespace binnacle::constellation_simulator;
using namespace binnacle::test;
using Eigen::Vector3d;

namespace {

constexpr double degree = M_PI / 180;
const nlohmann::json no_errors = {{"pseudorange", {{"bias", 0}, {"noise", 0}}},
                                  {"range_rate", {{"noise", 0}}},
                                  {"clock", {{"S_f", 0}, {"S_g", 0}, {"bias", 0}, {"drift", 0}}}};

struct Seen {
  double range, rate;
};
using Epoch = std::map<int, Seen>;

/// Keeps what the simulator emits, epoch by epoch.
class Collector {
 public:
  void receive(const ConstellationSimulator& simulator, const SampleView& sample, std::vector<std::byte>& memory) {
    static const ComponentSpec spec = ConstellationSimulator::spec();
    const auto made = binnacle::testing::TransformCaller(simulator, spec).on(0, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples) keep(emitted);
  }
  std::map<Time, Epoch> epochs;
  std::map<Time, Seen> clock;
  std::vector<gnss::Ephemeris> ephemerides;

 private:
  void keep(const binnacle::testing::Emitted& emitted) {
    const double* const rows = emitted.row_fields.data();
    if (emitted.channel == 0) {
      Epoch epoch;
      for (int i = 0; i < emitted.rows; ++i) epoch[static_cast<int>(rows[3 * i])] = {rows[3 * i + 1], rows[3 * i + 2]};
      epochs[emitted.t] = epoch;
    } else if (emitted.channel == 1) {
      for (int i = 0; i < emitted.rows; ++i)
        ephemerides.push_back(gnss::read_ephemeris(rows + i * gnss::ephemeris_field_count));
    } else {
      clock[emitted.t] = {emitted.fields[0], emitted.fields[1]};
    }
  }
};

struct Vehicle {
  Vector3d lla{37.5 * degree, 127 * degree, 100};
  Vector3d v_n = Vector3d::Zero();
  Vector3d angles = Vector3d::Zero();
};

nlohmann::json with(nlohmann::json more) {
  nlohmann::json all = no_errors;
  all.merge_patch(more);
  return all;
}

Collector collect(const nlohmann::json& parameters, const Vehicle& vehicle, double duration, double step = 1,
                  std::uint64_t seed = 1) {
  const auto simulator = bind<ConstellationSimulator>({parameters, {}, {}});
  std::vector<std::byte> memory(simulator->declaration().memory_bytes);
  simulator->start(seed, memory.data());
  Collector collected;
  for (int k = 0; k <= std::lround(duration / step); ++k) {
    double fields[9];
    vector_at<3>(&fields[0]) = vehicle.lla;
    vector_at<3>(&fields[3]) = vehicle.v_n;
    vector_at<3>(&fields[6]) = vehicle.angles;
    SampleView sample;
    sample.t = nanoseconds(k * step), sample.fields = fields;
    collected.receive(*simulator, sample, memory);
  }
  return collected;
}

/// Where a satellite on a circular orbit is in axes that do not turn with the earth and agree with ECEF at the week's begin.
Vector3d inertial(const gnss::Ephemeris& s, double t) {
  const double n = std::sqrt(3.986005e14 / std::pow(s.semi_major_axis, 3));
  const double u = s.m0 + s.perigee + n * (t - s.toe);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(s.omega0, Vector3d::UnitZ()) * Eigen::AngleAxisd(s.i0, Vector3d::UnitX())).toRotationMatrix();
  return turn * Vector3d(s.semi_major_axis * std::cos(u), s.semi_major_axis * std::sin(u), 0);
}

}  // namespace

TEST_CASE("24 satellites in 6 planes, of which 6 to 12 are above 10 deg", "[constellation_simulator]") {
  const Collector collected = collect(no_errors, {}, 86400, 600);
  REQUIRE(collected.ephemerides.size() == 24);
  std::size_t fewest = 99, most = 0;
  for (const auto& [t, epoch] : collected.epochs)
    fewest = std::min(fewest, epoch.size()), most = std::max(most, epoch.size());
  INFO(fewest << " to " << most);
  REQUIRE(fewest >= 4);
  REQUIRE(most <= 12);
  REQUIRE(std::abs(collected.ephemerides[4].omega0 - 60 * degree) < 1e-12);
  REQUIRE(std::abs(collected.ephemerides[1].m0 - 90 * degree) < 1e-12);
}

TEST_CASE("a range is the way of the light in axes that do not turn", "[constellation_simulator]") {
  const Vehicle vehicle;
  const Collector collected = collect(no_errors, vehicle, 3000, 1000);
  const double omega_e = 7.2921151467e-5, c = 299792458.0;
  const Vector3d r_e = strapdown::ecef_from_lla(vehicle.lla);
  for (const auto& [time, epoch] : collected.epochs)
    for (const auto& [key, seen] : epoch) {
      const double t = seconds(time);
      const Vector3d here = Eigen::AngleAxisd(omega_e * t, Vector3d::UnitZ()) * r_e;
      double travel = 0.07;
      for (int i = 0; i < 8; ++i)
        travel = (inertial(collected.ephemerides[static_cast<std::size_t>(key - 101)], t - travel) - here).norm() / c;
      REQUIRE(std::abs(seen.range - travel * c) < 1e-5);
    }
}

TEST_CASE("a range rate is the rate of the range, standing and moving", "[constellation_simulator]") {
  for (const Vector3d& v_n : {Vector3d(0, 0, 0), Vector3d(30, -200, 5)}) {
    // A step of the position by v dt stands for the motion.
    const double dt = 0.5;
    std::vector<Epoch> at;
    for (const double t : {100 - dt, 100.0, 100 + dt}) {
      Vehicle vehicle;
      vehicle.v_n = v_n;
      vehicle.lla = strapdown::position_plus(vehicle.lla, v_n * (t - 100));
      const auto simulator = bind<ConstellationSimulator>({no_errors, {}, {}});
      std::vector<std::byte> memory(simulator->declaration().memory_bytes);
      simulator->start(1, memory.data());
      Collector collected;
      double fields[9] = {};
      vector_at<3>(&fields[0]) = vehicle.lla;
      vector_at<3>(&fields[3]) = v_n;
      SampleView sample;
      sample.t = nanoseconds(t), sample.fields = fields;
      collected.receive(*simulator, sample, memory);
      at.push_back(collected.epochs.begin()->second);
    }
    REQUIRE(at[1].size() >= 5);
    for (const auto& [key, seen] : at[1]) {
      if (!at[0].contains(key) || !at[2].contains(key)) continue;
      REQUIRE(std::abs(seen.rate - (at[2].at(key).range - at[0].at(key).range) / (2 * dt)) < 2e-3);
    }
  }
}

TEST_CASE("the receiver's clock moves all ranges alike, and wanders as its densities say",
          "[constellation_simulator]") {
  const Collector exact = collect(no_errors, {}, 20);
  const Collector collected =
      collect(with({{"clock", {{"S_f", 0.009}, {"S_g", 0.0355}, {"bias", 100}, {"drift", 1}}}}), {}, 20);
  for (const auto& [t, epoch] : collected.epochs)
    for (const auto& [key, seen] : epoch) {
      REQUIRE(std::abs(seen.range - exact.epochs.at(t).at(key).range - collected.clock.at(t).range) < 1e-3);
      REQUIRE(std::abs(seen.rate - exact.epochs.at(t).at(key).rate - collected.clock.at(t).rate) < 1e-4);
    }
  double drift = 0, bias = 0;
  const int runs = 400;
  for (int run = 0; run < runs; ++run) {
    const Collector one = collect(with({{"clock", {{"S_f", 0.009}, {"S_g", 0.0355}, {"bias", 0}, {"drift", 0}}}}), {},
                                  10, 1, 100 + static_cast<std::uint64_t>(run));
    drift += std::pow(one.clock.rbegin()->second.rate, 2) / runs;
    bias += std::pow(one.clock.rbegin()->second.range, 2) / runs;
  }
  // After 10 s: S_g t, and S_f t + S_g t^3/3. A variance over 400 runs is known to 7 %; four of these.
  REQUIRE(std::abs(drift / 0.355 - 1) < 0.28);
  REQUIRE(std::abs(bias / (0.09 + 11.83) - 1) < 0.28);
}

TEST_CASE("slow and white errors have the deviations that were asked for", "[constellation_simulator]") {
  const double spacing = 1800;  // one correlation time
  const Collector exact = collect(no_errors, {}, 86400 * 5, spacing);
  const Collector slow = collect(with({{"pseudorange", {{"bias", 6}, {"tau", 1800}}}}), {}, 86400 * 5, spacing);
  const Collector white =
      collect(with({{"pseudorange", {{"noise", 2}}}, {"range_rate", {{"noise", 0.05}}}}), {}, 86400 * 5, spacing);
  double square = 0, product = 0, white_square = 0, rate_square = 0;
  int n = 0, pairs = 0;
  std::map<int, double> before;
  for (const auto& [t, epoch] : exact.epochs) {
    std::map<int, double> now;
    for (const auto& [key, seen] : epoch) {
      const double error = slow.epochs.at(t).at(key).range - seen.range;
      now[key] = error;
      square += error * error, ++n;
      if (before.contains(key)) product += error * before[key], ++pairs;
      white_square += std::pow(white.epochs.at(t).at(key).range - seen.range, 2);
      rate_square += std::pow(white.epochs.at(t).at(key).rate - seen.rate, 2);
    }
    before = now;
  }
  INFO(n << " errors, " << pairs << " pairs");
  REQUIRE(n > 1500);
  REQUIRE(std::abs(square / n / 36 - 1) < 0.15);
  REQUIRE(std::abs(product / pairs / 36 - std::exp(-1.0)) < 0.12);
  REQUIRE(std::abs(white_square / n / 4 - 1) < 0.12);
  REQUIRE(std::abs(rate_square / n / 0.0025 - 1) < 0.12);
}

TEST_CASE("masks and cuts take satellites away and change no other figure", "[constellation_simulator]") {
  const nlohmann::json noisy = {{"elevation_mask", 0.1}};
  const Collector all = collect(noisy, {}, 60);
  const Collector cut =
      collect({{"elevation_mask", 0.1},
               {"cuts",
                {{{"from", 20}, {"to", 30}, {"satellites", 3}}, {{"from", 40}, {"to", 45}, {"satellites", 0}}}}},
              {}, 60);
  for (const auto& [t, epoch] : all.epochs) {
    const auto s = t / nanoseconds_per_second;
    CAPTURE(s);
    if (s >= 40 && s <= 45) {
      REQUIRE(!cut.epochs.contains(t));
      continue;
    }
    REQUIRE(cut.epochs.at(t).size() == (s >= 20 && s <= 30 ? 3u : epoch.size()));
    for (const auto& [key, seen] : cut.epochs.at(t)) REQUIRE(seen.range == epoch.at(key).range);
  }
  Vehicle banked;
  banked.angles = {60 * degree, 0, 0};
  const Collector level = collect(with({{"antenna_mask", 0}}), {}, 0);
  const Collector bank = collect(with({{"antenna_mask", 0}}), banked, 0);
  REQUIRE(bank.epochs.begin()->second.size() < level.epochs.begin()->second.size());
  for (const auto& [key, seen] : bank.epochs.begin()->second) {
    // Rolled 60 deg to the right, up leans east: what is left stands on that side of the body's plane.
    const Vector3d r_e = strapdown::ecef_from_lla(banked.lla);
    const auto state =
        gnss::satellite_state(bank.ephemerides[static_cast<std::size_t>(key - 101)], 0, seen.range / 299792458.0);
    const Vector3d ned =
        strapdown::C_en(banked.lla[0], banked.lla[1]).transpose() * (state.position - r_e).normalized();
    REQUIRE(std::sin(60 * degree) * ned.y() - std::cos(60 * degree) * ned.z() > -1e-5);
  }
}

TEST_CASE("faults and clock jumps come when they are said to", "[constellation_simulator]") {
  const Collector good = collect(no_errors, {}, 20);
  const int first = good.epochs.begin()->second.begin()->first;
  const std::string name = gnss::satellite_name(first);
  const Collector bad =
      collect(with({{"faults",
                     {{{"satellite", name}, {"from", 5}, {"to", 8}, {"pseudorange", 1000}, {"range_rate", 3}}}},
                    {"clock_jumps", {{{"at", 12}, {"jump", 1e-3}}}}}),
              {}, 20);
  for (const auto& [t, epoch] : good.epochs)
    for (const auto& [key, seen] : epoch) {
      const auto s = t / nanoseconds_per_second;
      const bool is_faulty = key == first && s >= 5 && s <= 8;
      const double jump = s >= 12 ? 299792.458 : 0;
      // After the jump the label is 1 ms late: the satellite was elsewhere when it sent, by less than 1 m of range.
      REQUIRE(std::abs(bad.epochs.at(t).at(key).range - seen.range - (is_faulty ? 1000 : 0) - jump) <
              (s >= 12 ? 1.0 : 1e-6));
      REQUIRE(std::abs(bad.epochs.at(t).at(key).rate - seen.rate - (is_faulty ? 3 : 0)) < 1e-2);
    }
}

TEST_CASE("a fault of a satellite that is not there is refused", "[constellation_simulator]") {
  for (const char* name : {"G30", "E05", "X1"})
    REQUIRE_THROWS_AS(
        bind<ConstellationSimulator>(
            {with({{"faults", {{{"satellite", name}, {"from", 0}, {"to", 1}, {"pseudorange", 1000}}}}}), {}, {}}),
        ComponentError);
}

TEST_CASE("a YUMA almanac is read, its unhealthy satellites are left out, and its damage is reported with the line",
          "[constellation_simulator]") {
  const auto file = std::filesystem::temp_directory_path() / "binnacle_constellation_test.alm";
  const auto write = [&](const std::string& text) { std::ofstream(file) << text; };
  const auto satellite = [](int id, const char* health, const char* root) {
    return "******** Week 215 almanac for PRN-" + std::to_string(id) +
           " ********\nID:                         " + std::to_string(id) + "\nHealth:                     " + health +
           "\nEccentricity:               0.5E-002\nTime of Applicability(s):  405504.0000\n"
           "Orbital Inclination(rad):   0.96\nRate of Right Ascen(r/s):  -0.8E-008\nSQRT(A)  (m 1/2):           " +
           root +
           "\nRight Ascen at Week(rad):   0.3E+000\nArgument of Perigee(rad):   1.5\nMean Anom(rad):            -2.1\n"
           "Af0(s):                     0.1E-004\nAf1(s/s):                   0.3E-011\nweek:                        "
           "215\n\n";
  };
  write(satellite(3, "000", "5153.6") + satellite(7, "063", "5153.5") + satellite(9, "000", "5153.7"));
  const auto read = read_almanac(file.string());
  REQUIRE(read.size() == 2);
  REQUIRE(read[0].satellite == 103);
  REQUIRE(read[1].satellite == 109);
  REQUIRE(std::abs(read[0].semi_major_axis - 5153.6 * 5153.6) < 1e-3);
  REQUIRE(read[0].toc == 405504);
  REQUIRE(read[0].af1 == 0.3e-11);
  // Two weeks in one file: which of them is meant?
  write(satellite(3, "000", "5153.6") + satellite(3, "000", "5153.6"));
  REQUIRE_THROWS_AS(read_almanac(file.string()), ComponentError);
  write(satellite(3, "000", "51x3.6"));
  try {
    read_almanac(file.string());
    FAIL("it was taken");
  } catch (const ComponentError& error) {
    REQUIRE(error.line() == 8);
    REQUIRE(error.is_data_error());
  }
  std::filesystem::remove(file);
}

}  // namespace constellation_simulator_test
