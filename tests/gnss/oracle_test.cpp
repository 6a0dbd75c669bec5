// SPDX-License-Identifier: Apache-2.0
// Satellite states and ranges from recorded broadcast messages against oracle tables made by other code.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "catch.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/corrections.hpp"
#include "gnss/gps_time.hpp"
#include "gnss/message_choice.hpp"
#include "gnss/orbit.hpp"
#include "gnss/signal_path.hpp"
#include "gnss_data.hpp"
#include "rinex/navigation_file.hpp"
#include "strapdown/earth.hpp"

namespace oracle_test {

using namespace binnacle;
using namespace binnacle::gnss;

namespace {

class Silent final : public Reporter {
 public:
  void warn(const std::string& code, const std::string& file, int line, const std::string& message) override {
    UNSCOPED_INFO(code << " " << file << ":" << line << " " << message);
    ++warnings;
  }
  int warnings = 0;
};

using Row = std::map<std::string, std::string>;

double value(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

/// Time zero is that of GPS week 0, so that weeks are exercised.
Time time_of(const Row& row, const char* column) {
  return std::stoll(row.at("week")) * seconds_per_week * nanoseconds_per_second + nanoseconds(value(row, column));
}

class Broadcasts {
 public:
  explicit Broadcasts(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const rinex::Navigation& file(const std::string& name) {
    auto& navigation = files_[name];
    if (navigation.messages.empty()) {
      Silent silent;
      const std::string path = (folder_ / name).string();
      rinex::Faults faults(path, rinex::OnInvalid::error, silent);
      navigation = rinex::read_navigation(path, 0, faults);
      REQUIRE(silent.warnings == 0);
      REQUIRE(navigation.klobuchar);
    }
    return navigation;
  }
  const Ephemeris& message(const Row& row, Time t) {
    const auto& messages = file(row.at("nav")).messages;
    const gnss::ChoiceRules rules{gnss::Choice::nearest_toe, 7200 * nanoseconds_per_second, false};
    const auto sets = gnss::choose_messages(messages, rules, t, t);
    for (const std::size_t i : sets.front().messages)
      if (messages[i].ephemeris.satellite == satellite_key(Constellation::gps, std::stoi(row.at("prn"))))
        return messages[i].ephemeris;
    throw std::logic_error("no message");
  }

 private:
  std::filesystem::path folder_;
  std::map<std::string, rinex::Navigation> files_;
};

}  // namespace

TEST_CASE("satellite states equal the oracle's") {
  const auto data = test::gnss_data();
  if (!data) return;
  Broadcasts broadcasts(*data / "rinex");
  const auto rows = test::table(*data / "oracle" / "oracle_sat.csv");
  REQUIRE(rows.size() == 18);
  double position = 0, velocity = 0, clock = 0, drift = 0;
  for (const Row& row : rows) {
    const Time t = time_of(row, "sow");
    const Ephemeris& message = broadcasts.message(row, t);
    INFO(row.at("nav") << " G" << row.at("prn") << " at " << row.at("sow"));
    REQUIRE(time_of_week(message.toe) == value(row, "toe"));
    REQUIRE(message.issue == value(row, "iode"));
    REQUIRE(std::abs(message.group_delay - value(row, "tgd_s")) < 1e-17);
    const SatelliteState state = satellite_state(message, t);
    const Eigen::Vector3d r(value(row, "x_m"), value(row, "y_m"), value(row, "z_m"));
    const Eigen::Vector3d v(value(row, "vx_mps"), value(row, "vy_mps"), value(row, "vz_mps"));
    position = std::max(position, (state.position - r).norm());
    velocity = std::max(velocity, (state.velocity - v).norm());
    clock = std::max(clock, std::abs(state.clock - value(row, "clk_s")) * speed_of_light);
    drift = std::max(drift, std::abs(state.clock_drift - value(row, "clk_drift_sps")));
    CHECK((state.position - r).norm() < 1e-3);
    CHECK((state.velocity - v).norm() < 1e-5);
    CHECK(std::abs(state.clock - value(row, "clk_s")) * speed_of_light < 1e-3);
    CHECK(std::abs(state.clock_drift - value(row, "clk_drift_sps")) < 1e-16);
    CHECK(satellite_clock(message, t, 0) == state.clock);
  }
  std::printf("satellites: position %.1e m, velocity %.1e m/s, clock %.1e m, drift %.1e at most\n", position, velocity,
              clock, drift);
}

TEST_CASE("ranges, directions and atmosphere equal the oracle's") {
  const auto data = test::gnss_data();
  if (!data) return;
  Broadcasts broadcasts(*data / "rinex");
  const auto rows = test::table(*data / "oracle" / "oracle_range.csv");
  REQUIRE(rows.size() == 37);
  const std::map<std::string, Eigen::Vector3d> antennas{
      {"07590920.05n", strapdown::ecef_from_lla({35.160866522 * M_PI / 180, 139.613842697 * M_PI / 180, 68.389})},
      {"SEPT078M.21P", {-3962108.673, 3381309.574, 3668678.638}}};
  double satellite = 0, range = 0, angle = 0, ionosphere = 0, troposphere = 0, model_error = 0;
  for (const Row& row : rows) {
    const Time t = time_of(row, "sow_rx");
    const Ephemeris& message = broadcasts.message(row, t);
    INFO(row.at("nav") << " G" << row.at("prn") << " at " << row.at("sow_rx"));
    const AntennaPlace antenna = place_from_ecef(antennas.at(row.at("nav")));
    double back = value(row, "C1C_m") / speed_of_light;
    back += satellite_clock(message, t, back);
    const SatelliteState state = satellite_state(message, t, back);
    const SignalPath path = signal_path(state.position, antenna.ecef, true);
    const Direction direction = direction_in(antenna.C_en, path.direction);
    const double iono = klobuchar_delay(*broadcasts.file(row.at("nav")).klobuchar, antenna.lla[0], antenna.lla[1],
                                        direction.azimuth, direction.elevation, time_of_day(t));
    const double tropo =
        troposphere_delay(Mapping::cosecant, antenna.lla[0], antenna.lla[2], direction.elevation, 0).delay;
    const double model = path.range - speed_of_light * (state.clock - message.group_delay) + iono + tropo;

    const Eigen::Vector3d r(value(row, "sx_m"), value(row, "sy_m"), value(row, "sz_m"));
    satellite = std::max(satellite, (state.position - r).norm());
    range = std::max(range, std::abs(path.range - value(row, "range_sagnac_m")));
    angle = std::max({angle, std::abs(direction.azimuth * 180 / M_PI - value(row, "az_deg")),
                      std::abs(direction.elevation * 180 / M_PI - value(row, "el_deg"))});
    ionosphere = std::max(ionosphere, std::abs(iono - value(row, "iono_m")));
    troposphere = std::max(troposphere, std::abs(tropo - value(row, "tropo_m")));
    model_error = std::max(model_error, std::abs(model - value(row, "model_no_rxclk_m")));
    CHECK((state.position - r).norm() < 1e-3);
    CHECK(std::abs(path.range - value(row, "range_sagnac_m")) < 1e-3);
    CHECK(std::abs(direction.azimuth * 180 / M_PI - value(row, "az_deg")) < 2e-5);
    CHECK(std::abs(direction.elevation * 180 / M_PI - value(row, "el_deg")) < 2e-5);
    CHECK(std::abs(iono - value(row, "iono_m")) < 2e-3);
    CHECK(std::abs(tropo - value(row, "tropo_m")) < 2e-3);
    CHECK(std::abs(model - value(row, "model_no_rxclk_m")) < 3e-3);
  }
  std::printf(
      "ranges: satellite %.1e m, range %.1e m, angles %.1e deg, ionosphere %.1e m, troposphere %.1e m, all %.1e m\n",
      satellite, range, angle, ionosphere, troposphere, model_error);
}

TEST_CASE("Galileo's two clocks are one on E1, each with its own group delay") {
  const auto data = test::gnss_data();
  if (!data) return;
  Broadcasts broadcasts(*data / "rinex");
  const auto& messages = broadcasts.file("SEPT078M.21P").messages;
  int pairs = 0;
  double squares = 0, most = 0;
  for (const auto& f : messages)
    for (const auto& i : messages) {
      const Ephemeris &a = f.ephemeris, &b = i.ephemeris;
      if (!f.is_substitute || i.is_substitute || a.satellite != b.satellite || a.issue != b.issue || a.toc != b.toc)
        continue;
      const double apart = speed_of_light * ((a.af0 - a.group_delay) - (b.af0 - b.group_delay));
      squares += apart * apart;
      most = std::max(most, std::abs(apart));
      ++pairs;
    }
  const double rms = std::sqrt(squares / pairs);
  std::printf("Galileo: clocks of E1 by F/NAV and I/NAV, %d pairs: %.3f m RMS apart, %.3f m at most\n", pairs, rms,
              most);
  CHECK(pairs >= 96);
  CHECK(rms < 0.15);  // 1.08 m with the other delay
}

}  // namespace oracle_test
