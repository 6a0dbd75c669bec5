// SPDX-License-Identifier: Apache-2.0
// Satellites given by the rows of a channel, several systems, and noise by row, elevation and C/N0.
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "../../plugins/gnss_range/pseudorange.hpp"
#include "../../plugins/gnss_range/range_rate.hpp"
#include "../plugins/bind.hpp"
#include "../plugins/model_check.hpp"
#include "catch.hpp"
#include "sky.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace given_test {

using namespace binnacle;
using namespace binnacle::gnss_range;
using namespace binnacle::test;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

const Vector3d home(0.61, 2.21, 400.0);  // lat, lon, height

const AdditiveKind ecef_position("position.ecef", 3, "m"), ecef_velocity("velocity.ecef", 3, "m/s"),
    receiver_clock("receiver_clock", 2, "m"), one_offset(1, "m"), two_offsets(2, "m");
const PositionKind geodetic;

/// Where a field stands in a row as models read it.
std::size_t column(const std::string& name) {
  auto fields = gnss::observation_fields(true);
  for (auto& field : gnss::given_fields()) fields.push_back(std::move(field));
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i].name == name) return i;
  throw std::logic_error(name);
}

/// A receiver under a sky, and its rows with satellites, systems 1, 2 and 3 by turns.
struct Given {
  Sky sky;
  Vector3d r0 = strapdown::ecef_from_lla(home), v_e{20, -30, 10};
  double bias = 0.0021, drift = 1.1e-7, label = 9000.25;  // s, s/s, s
  std::vector<double> plain, rows, ephemerides = sky.ephemeris_rows();

  Given() {
    const double t0 = label - bias;
    const Track track = [=, this](double t) { return Vector3d(r0 + (t - t0) * v_e); };
    const ClockTrack clock = [=, this](double t) { return bias + (t - t0) * drift; };
    plain = sky.observe(label, track, clock);
    rows = widened(plain);
    for (std::size_t i = 0; i < count(); ++i) {
      const auto key = static_cast<int>(at(i, "satellite"));
      const gnss::Ephemeris& e = sky.ephemerides[static_cast<std::size_t>(key - 101)];
      // The satellite's own time of transmission, and from that the system's.
      double back = at(i, "pseudorange") / gnss::speed_of_light;
      back += gnss::satellite_clock(e, nanoseconds(label), back);
      const gnss::SatelliteState s = gnss::satellite_state(e, nanoseconds(label), back);
      for (int axis = 0; axis < 3; ++axis) {
        const std::string letter(1, "xyz"[axis]);
        at(i, "satellite_" + letter) = s.position[axis];
        at(i, "satellite_v" + letter) = s.velocity[axis];
      }
      at(i, "satellite_clock") = s.clock - e.group_delay;
      at(i, "satellite_clock_drift") = s.clock_drift;
      at(i, "satellite") = key - 100;
      at(i, "system") = 1 + static_cast<double>(i % 3);
    }
  }
  std::size_t width() const { return static_cast<std::size_t>(wide_fields()); }
  std::size_t count() const { return rows.size() / width(); }
  double& at(std::size_t row, const std::string& field) { return rows[row * width() + column(field)]; }
  SampleView sample() const { return rows_view(rows, wide_fields(), nanoseconds(label)); }
  std::vector<double> ecef() const { return {r0[0], r0[1], r0[2]}; }
  std::vector<double> clock() const { return {bias * gnss::speed_of_light, drift * gnss::speed_of_light}; }
};

const std::vector<std::string> sigmas{"pseudorange_sigma", "pseudorange_variance", "range_rate_sigma",
                                      "range_rate_variance"};

std::vector<std::string> without(std::vector<std::string> more = {}) {
  for (const auto& name : sigmas)
    if (std::find(more.begin(), more.end(), "+" + name) == more.end()) more.push_back(name);
  more.emplace_back("ephemeris");
  more.emplace_back("iono");
  return more;
}

const Ports by_ecef{{"ecef_position", &ecef_position}, {"clock", &receiver_clock}};
const Ports with_offsets{{"ecef_position", &ecef_position},
                         {"clock", &receiver_clock},
                         {"system_offset", &two_offsets}};
const Ports rate_ports{{"ecef_position", &ecef_position},
                       {"ecef_velocity", &ecef_velocity},
                       {"clock", &receiver_clock}};
const json three{{"systems", {1, 2, 3}}, {"elevation_mask", 0.0}};

/// The auxiliary channels that are not there.
struct Nothing {
  SampleView views[2];
  Nothing() { views[0].available = views[1].available = false; }
};

/// A call, and the notes that it leaves.
struct Call {
  Measured measured;
  std::vector<std::string> notes;
};
template <class Model>
Call call(const Setup& setup, const SampleView& sample, const PortStates& ports) {
  const auto model = bind<Model>(setup);
  const Nothing nothing;
  Complaints out;
  Call made{linearize(*model, sample, ports, {}, out, nothing.views), {}};
  REQUIRE(out.empty());
  return made;
}

std::string refusal(const std::function<void()>& bind) {
  try {
    bind();
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "bound";
}

}  // namespace

TEST_CASE("given satellites predict what an ephemeris predicts, to the micrometre") {
  Given given;
  Nothing auxiliary;
  SampleView channels[2];
  channels[0] = rows_view(given.ephemerides, gnss::ephemeris_field_count, 0);
  channels[1].available = false;
  const std::vector<double> wide = widened(given.plain);
  const SampleView plain = rows_view(wide, wide_fields(), nanoseconds(given.label));
  Complaints out;
  {
    const PortStates ports{{}, {&ecef_position, given.ecef()}, {&receiver_clock, given.clock()}, {}};
    const Measured by_message = linearize(*bind_by_ephemeris<Pseudorange>({{{"elevation_mask", 0.0}}, by_ecef, {}}),
                                          plain, ports, {}, out, channels);
    const Call by_row = call<Pseudorange>({three, by_ecef, without()}, given.sample(), ports);
    REQUIRE(by_row.measured.result);
    REQUIRE(by_row.measured.residual.size() == by_message.residual.size());
    CHECK((by_row.measured.residual - by_message.residual).cwiseAbs().maxCoeff() < 1e-6);
    CHECK((by_row.measured.H[0] - by_message.H[0]).cwiseAbs().maxCoeff() < 1e-12);
    CHECK(by_row.measured.residual.cwiseAbs().maxCoeff() < 1e-4);
    CHECK(by_row.measured.keys[0] == 1000 + by_message.keys[0] - 100);
  }
  const PortStates ports{
      {}, {&ecef_position, given.ecef()}, {}, {&ecef_velocity, {20, -30, 10}}, {&receiver_clock, given.clock()}};
  const Measured by_message = linearize(*bind_by_ephemeris<RangeRateModel>({{{"elevation_mask", 0.0}}, rate_ports, {}}),
                                        plain, ports, {}, out, channels);
  const Call by_row = call<RangeRateModel>({three, rate_ports, without()}, given.sample(), ports);
  REQUIRE(by_row.measured.residual.size() == by_message.residual.size());
  CHECK((by_row.measured.residual - by_message.residual).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(by_row.measured.residual.cwiseAbs().maxCoeff() < 1e-3);
}

TEST_CASE("positions in axes of reception need no turn of the earth") {
  Given given;
  const PortStates ports{{}, {&ecef_position, given.ecef()}, {&receiver_clock, given.clock()}, {}};
  const auto before = call<Pseudorange>({three, by_ecef, without()}, given.sample(), ports).measured.residual;
  for (std::size_t i = 0; i < given.count(); ++i) {
    const Vector3d r(given.at(i, "satellite_x"), given.at(i, "satellite_y"), given.at(i, "satellite_z"));
    const Vector3d turned =
        Eigen::AngleAxisd(-gnss::omega_e * (r - given.r0).norm() / gnss::speed_of_light, Vector3d::UnitZ()) * r;
    given.at(i, "satellite_x") = turned.x(), given.at(i, "satellite_y") = turned.y();
  }
  json standing = three;
  standing["earth_rotation"] = false;
  const auto after = call<Pseudorange>({standing, by_ecef, without()}, given.sample(), ports).measured.residual;
  CHECK((after - before).cwiseAbs().maxCoeff() < 1e-3);
  // Taken for what they are not, some are tens of metres off: the Sagnac effect.
  const auto wrong = call<Pseudorange>({three, by_ecef, without()}, given.sample(), ports).measured.residual;
  CHECK((wrong - before).cwiseAbs().maxCoeff() > 10);
}

TEST_CASE("H of given satellites against differences, with an offset for each system but the first") {
  const Given given;
  const Nothing nothing;
  std::vector<double> x = given.ecef(), clock{given.clock()[0] + 500, 3};
  x[0] += 300, x[1] -= 200;
  const auto model = bind<Pseudorange>({three, with_offsets, without()});
  const PortStates ports{{}, {&ecef_position, x, 10}, {&receiver_clock, clock, 1}, {&two_offsets, {40.0, -25.0}, 1}};
  REQUIRE_NO_COMPLAINTS(
      check_measurement(*model, Pseudorange::spec(), given.sample(), ports, {}, {1e-8}, 1e-8, nothing.views));
  const Ports local{{"position", &geodetic}, {"clock", &receiver_clock}, {"system_offset", &two_offsets}};
  const auto geodetic_model = bind<Pseudorange>({three, local, without()});
  REQUIRE_NO_COMPLAINTS(check_measurement(*geodetic_model, Pseudorange::spec(), given.sample(),
                                          {{&geodetic, {home[0], home[1], home[2]}, 10, 1e-8},
                                           {},
                                           {&receiver_clock, clock, 1},
                                           {&two_offsets, {40.0, -25.0}, 1}},
                                          {}, {1e-8}, 1e-8, nothing.views));
  const auto rates = bind<RangeRateModel>({three, rate_ports, without()});
  REQUIRE_NO_COMPLAINTS(check_measurement(*rates, RangeRateModel::spec(), given.sample(),
                                          {{},
                                           {&ecef_position, given.ecef(), 100},
                                           {},
                                           {&ecef_velocity, {200, -100, 50}, 1},
                                           {&receiver_clock, {0, 30}, 1}},
                                          {}, {2e-5}, 1e-11, nothing.views));
}

TEST_CASE("an offset is what a system's pseudoranges have more") {
  Given given;
  for (std::size_t i = 0; i < given.count(); ++i) given.at(i, "pseudorange") += 10.0 * static_cast<double>(i % 3);
  const PortStates right{{},
                         {&ecef_position, given.ecef()},
                         {&receiver_clock, given.clock()},
                         {&two_offsets, {10.0, 20.0}}};
  const auto made = call<Pseudorange>({three, with_offsets, without()}, given.sample(), right).measured;
  // The time of transmission is the given one, so that nothing but the offsets is in the residuals.
  CHECK(made.residual.cwiseAbs().maxCoeff() < 1e-4);
  for (Eigen::Index i = 0; i < made.residual.size(); ++i) {
    CHECK(made.H[2](i, 0) == (i % 3 == 1));
    CHECK(made.H[2](i, 1) == (i % 3 == 2));
    CHECK(made.H[1](i, 0) == 1);
  }
}

TEST_CASE("rows that can not be used are left out: another system, no position, twice, no C/N0") {
  const PortStates ports{{}, {&ecef_position, Given().ecef()}, {&receiver_clock, Given().clock()}, {}};
  const auto rows = [&](Given& given, json more = json::object(), std::vector<std::string> fields = without()) {
    json all = three;
    all.merge_patch(more);
    return call<Pseudorange>({all, by_ecef, fields}, given.sample(), ports).measured;
  };
  Given given;
  const auto all = static_cast<Eigen::Index>(given.count());
  REQUIRE(all >= 6);
  CHECK(rows(given).residual.size() == all);
  CHECK(rows(given, {{"systems", {1, 2}}}).residual.size() == all - all / 3);
  CHECK(rows(given, {{"systems", {9}}}).result.refusal == Refusal::unsupported);
  for (const double wrong : {std::nan(""), 0.0, 2.6e4, 1e12, static_cast<double>(INFINITY)}) {
    Given broken;
    broken.at(1, "satellite_x") = wrong;
    if (wrong == 2.6e4) broken.at(1, "satellite_y") = broken.at(1, "satellite_z") = 0;  // kilometres
    if (wrong == 0) broken.at(1, "satellite_y") = broken.at(1, "satellite_z") = 0;
    CHECK(rows(broken).residual.size() == all - 1);
  }
  {
    Given broken;
    broken.at(1, "satellite_clock") = std::nan("");
    CHECK(rows(broken).residual.size() == all - 1);
    broken = Given();
    broken.at(3, "satellite") = broken.at(0, "satellite");  // both of system 1
    CHECK(rows(broken).residual.size() == all - 1);
    broken = Given();
    broken.at(2, "system") = 1.5;
    CHECK(rows(broken).residual.size() == all - 1);
  }
  for (const double wrong : {std::nan(""), 0.0, -3.0}) {
    Given broken;
    broken.at(2, "cn0") = wrong;
    CHECK(rows(broken).residual.size() == all);  // nobody asks for it
    CHECK(rows(broken, {{"sigma_cn0", 1}}).residual.size() == all - 1);
    CHECK(rows(broken, {{"cn0_weight", json::object()}}).residual.size() == all - 1);
  }
  CHECK(rows(given, {{"exclude",
                      {"10" + std::to_string(static_cast<int>(given.at(0, "satellite")) / 10) +
                       std::to_string(static_cast<int>(given.at(0, "satellite")) % 10)}}})
            .residual.size() == all - 1);
}

TEST_CASE("noise by elevation and by C/N0 is that of its formula, and a row's own wins") {
  Given given;
  given.at(0, "cn0") = 25, given.at(1, "cn0") = 50, given.at(2, "cn0") = 35, given.at(3, "cn0") = 5;
  const PortStates ports{{}, {&ecef_position, given.ecef()}, {&receiver_clock, given.clock()}, {}};
  const auto R = [&](json more, std::vector<std::string> fields = without()) {
    json all = three;
    all.merge_patch(more);
    return Eigen::VectorXd(call<Pseudorange>({all, by_ecef, fields}, given.sample(), ports).measured.R.diagonal());
  };
  // SIGMA-epsilon: a + b 10^(-S/10) with a = 4, b = 9 · 10^4.
  const auto epsilon = R({{"sigma", 2}, {"sigma_cn0", 3}, {"cn0_reference", 40}});
  CHECK(std::abs(epsilon[0] - (4 + 9e4 * std::pow(10, -2.5))) < 1e-9);
  CHECK(std::abs(epsilon[1] - (4 + 0.9)) < 1e-12);
  // goGPS: at s1 and above nothing, at s0 and below the factor A, between them less than a straight line in decibel says.
  const auto flat = R({{"sigma", 2}}), weighed = R({{"sigma", 2}, {"cn0_weight", {{"A", 30}, {"a", 30}}}});
  CHECK(weighed[1] == flat[1]);
  CHECK(std::abs(weighed[3] / flat[3] - 30) < 1e-12);
  const double at25 = std::pow(10, 25.0 / 30) * ((30 / std::pow(10, 40.0 / 30) - 1) / -40.0 * -25.0 + 1);
  CHECK(std::abs(weighed[0] / flat[0] - at25) < 1e-9);
  CHECK(weighed[0] > weighed[2]);
  // What the row says.
  given.at(1, "pseudorange_sigma") = 7;
  given.at(2, "pseudorange_sigma") = 0;
  const auto own = R({{"sigma", 2}, {"sigma_elevation", 1}}, without({"+pseudorange_sigma"}));
  CHECK(own.size() == static_cast<Eigen::Index>(given.count()) - 1);  // one without any is left out
  CHECK(own[1] == 49);
  CHECK(own[0] > 4);  // a row that says nothing has the parameters'
  given.at(2, "pseudorange_variance") = 25;
  CHECK(R({{"sigma", 2}}, without({"+pseudorange_variance"}))[2] == 25);
}

TEST_CASE("what does not go together is refused when it is bound") {
  const auto pseudorange = [&](const json& parameters, const Ports& ports, std::vector<std::string> fields) {
    return refusal([&] { bind<Pseudorange>({parameters, ports, std::move(fields)}); });
  };
  CHECK(pseudorange(json::object(), by_ecef, without()).find("/systems: the channel carries 'system'") == 0);
  CHECK(pseudorange({{"systems", {1, 1}}}, by_ecef, without()) == "/systems/1: system 1 stands here twice");
  CHECK(pseudorange({{"systems", json::array()}}, by_ecef, without()).find("/systems: no system") == 0);
  CHECK(pseudorange({{"systems", {1, 2}}}, with_offsets, without()) ==
        "/blocks/system_offset: its block has 2 components where 'systems' lists 1 besides the first");
  CHECK(pseudorange(three, by_ecef, without({"satellite_y"})).find("all three, or none") != std::string::npos);
  CHECK(pseudorange(three, by_ecef, without({"satellite_x", "satellite_y", "satellite_z"})).find("not its position") !=
        std::string::npos);
  CHECK(pseudorange(three, by_ecef, without({"+pseudorange_sigma", "+pseudorange_variance"})).find("one of them") !=
        std::string::npos);
  CHECK(pseudorange({{"systems", {1, 2, 3}}, {"sigma_cn0", 1}}, by_ecef, without({"cn0"})) ==
        "/channel: the noise goes by C/N0, and the channel carries no 'cn0'");
  auto both = without();
  std::erase(both, std::string("ephemeris"));
  CHECK(pseudorange(three, by_ecef, both).find("/inputs/ephemeris: the channel gives") == 0);
  CHECK(refusal([&] {
          bind<RangeRateModel>({three, rate_ports, without({"satellite_vx", "satellite_vy", "satellite_vz"})});
        }).find("satellite_vx") != std::string::npos);
  CHECK(refusal([&] {
          Setup setup{json::object(), by_ecef, {"ephemeris"}};
          bind_by_ephemeris<Pseudorange>(setup);
        }).find("an ephemeris is needed") != std::string::npos);
  CHECK(pseudorange({{"systems", {1, 2, 3}}, {"sigma", 0}}, by_ecef, without()).find("/sigma") == 0);
  CHECK(
      pseudorange({{"systems", {1, 2, 3}}, {"cn0_weight", {{"s0", 60}}}}, by_ecef, without()).find("/cn0_weight/s0") ==
      0);
}

TEST_CASE("wild numbers in any field of a given row are refused or give finite rows") {
  const PortStates ports{{},
                         {&ecef_position, Given().ecef()},
                         {&receiver_clock, Given().clock()},
                         {&two_offsets, {1, 2}}};
  const PortStates rates{
      {}, {&ecef_position, Given().ecef()}, {}, {&ecef_velocity, {1, 2, 3}}, {&receiver_clock, Given().clock()}};
  std::vector<std::string> fields{"ephemeris", "iono", "pseudorange_variance", "range_rate_variance"};
  json all = three;
  all["sigma_cn0"] = 2;
  const auto ranging = bind<Pseudorange>({all, with_offsets, fields});
  const auto rating = bind<RangeRateModel>({all, rate_ports, fields});
  const Nothing nothing;
  for (const double number :
       {0.0, 1e-300, -1.0, 1e6, -1e9, 1e16, 1e300, -1e300, std::nan(""), static_cast<double>(INFINITY)})
    for (std::size_t field = 0; field < Given().width(); ++field) {
      Given broken;
      broken.rows[field] = broken.rows[3 * broken.width() + field] = number;
      Complaints out;
      for (const Measured& m : {linearize(*ranging, broken.sample(), ports, {}, out, nothing.views),
                                linearize(*rating, broken.sample(), rates, {}, out, nothing.views)}) {
        if (!m.result) continue;
        INFO("field " << field << " is " << number);
        CHECK(m.residual.allFinite());
        CHECK(m.R.allFinite());
        if (m.R.size() > 0) CHECK(m.R.diagonal().minCoeff() > 0);
        for (const auto& H : m.H) CHECK(H.allFinite());
      }
      CHECK(out.empty());
    }
}

}  // namespace given_test
