// SPDX-License-Identifier: Apache-2.0
// Plugin aiding, bearing: directions on all sides, Jacobians by differences, what cannot be seen.
#include "../../plugins/aiding/bearing.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace bearing_test {

using namespace binnacle;
using namespace binnacle::aiding;
using namespace binnacle::test;

namespace {

SampleView sample_of(const std::vector<double>& fields) {
  SampleView sample;
  sample.t = 0;
  sample.fields = fields.data();
  return sample;
}

constexpr double degree = std::numbers::pi / 180;

}  // namespace

TEST_CASE("bearing: clockwise from north, to all sides", "[aiding]") {
  const AdditiveKind target(2, "m");
  const auto model = bind<Bearing>({{{"sigma", 0.01}}, {{"target", &target}}, {"elevation", "observer_down"}});
  REQUIRE(model->declaration().max_rows == 1);
  for (const double azimuth : {0.0, 45.0, 90.0, 179.9, -179.9, -90.0, -3.0}) {
    CAPTURE(azimuth);
    // From (100, -50), 2 km away; measured two degrees further to the right.
    const std::vector<double> x{100 + 2000 * std::cos(azimuth * degree), -50 + 2000 * std::sin(azimuth * degree)};
    const std::vector<double> z{std::remainder((azimuth + 2) * degree, 2 * std::numbers::pi), NAN, 100, -50, NAN};
    const PortStates ports{{&target, x, 10.0, 1e-8}};
    Complaints out;
    const Measured m = linearize(*model, sample_of(z), ports, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    REQUIRE(m.result);
    CHECK(std::abs(m.residual[0] - 2 * degree) < 1e-12);
    CHECK(m.R(0, 0) == 1e-4);
    // A metre to the right is 1/2000 of a radian.
    const Eigen::Vector2d right(-std::sin(azimuth * degree), std::cos(azimuth * degree));
    CHECK(std::abs((m.H[0] * right)(0) - 1.0 / 2000) < 1e-12);
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, Bearing::spec(), sample_of(z), ports, {}, {1e-6}, 1e-8));
  }
}

TEST_CASE("bearing: elevation, and an observer that is a block", "[aiding]") {
  const AdditiveKind target(3, "m"), observer(3, "m");
  const auto model = bind<Bearing>({{{"sigma", 0.01}, {"elevation_sigma", 0.02}},
                                    {{"target", &target}, {"observer", &observer}},
                                    {"observer_north", "observer_east", "observer_down"}});
  REQUIRE(model->declaration().max_rows == 2);
  const std::vector<double> x{300, 400, -250}, from{0, 0, 250};
  const std::vector<double> z{0.9, 0.7, NAN, NAN, NAN};
  const PortStates ports{{&target, x, 10.0, 1e-8}, {&observer, from, 10.0, 1e-8}};
  Complaints out;
  const Measured m = linearize(*model, sample_of(z), ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  CHECK(std::abs(m.residual[0] - (0.9 - std::atan2(4, 3))) < 1e-14);
  CHECK(std::abs(m.residual[1] - (0.7 - std::numbers::pi / 4)) < 1e-14);
  CHECK(m.R(1, 1) == 4e-4);
  CHECK(m.H[0] == -m.H[1]);
  CHECK(m.H[0](1, 2) < 0);  // lower is less high
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, Bearing::spec(), sample_of(z), ports, {}, {1e-6}, 1e-8));
}

TEST_CASE("bearing: to a point on the earth, from north and from the body, each sign", "[aiding]") {
  const PositionKind geodetic;
  const AdditiveKind ecef("position.ecef", 3, "m"), heading("heading", 1, "rad");
  const AttitudeKind attitude;
  const Eigen::Vector3d lla(0.9, 0.2, 100), way(300, 400, -250);
  const Eigen::Matrix3d C_en = strapdown::C_en(lla[0], lla[1]);
  const Eigen::Vector3d here = strapdown::ecef_from_lla(lla), there = here + C_en * way,
                        lla_there = strapdown::lla_from_ecef(there);
  const nlohmann::json by_lla{{"lat", lla_there[0]}, {"lon", lla_there[1]}, {"height", lla_there[2]}},
      by_ecef{{"x", there[0]}, {"y", there[1]}, {"z", there[2]}},
      by_local{{"north", way[0]}, {"east", way[1]}, {"down", way[2]}},
      origin{{"lat", lla[0]}, {"lon", lla[1]}, {"height", lla[2]}};
  const Eigen::Vector4d q = strapdown::quaternion_from_euler({0.1, -0.2, 0.5});
  const Eigen::Vector3d body = strapdown::dcm_from_quaternion(q).transpose() * way,
                        car =
                            strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler({0, 0, 0.5})).transpose() *
                            way;
  for (const auto& point : {by_lla, by_ecef, by_local})
    for (const bool is_geodetic : {true, false})
      for (const std::string from : {"north", "body", "car"}) {
        CAPTURE(point.dump(), is_geodetic, from);
        const StateBlock& block = is_geodetic ? static_cast<const StateBlock&>(geodetic) : ecef;
        Ports plugged{{"observer", &block}};
        if (from == "body") plugged["attitude"] = &attitude;
        if (from == "car") plugged["heading"] = &heading;
        const auto model = bind<Bearing>({{{"sigma", 0.01}, {"point", point}, {"origin", origin}},
                                          plugged,
                                          {"observer_north", "observer_east", "observer_down"}});
        const Eigen::Vector3d x = is_geodetic ? lla : here, d = from == "north" ? way : from == "body" ? body : car;
        const PortStates ports{{},
                               {&block, {x[0], x[1], x[2]}, 1.0, 1e-8},
                               from == "body" ? PortState{&attitude, {q[0], q[1], q[2], q[3]}, 1e-2, 4e-16}
                                              : PortState{},
                               from == "car" ? PortState{&heading, {0.5}, 1e-2, 4e-16} : PortState{}};
        const std::vector<double> z{std::atan2(d[1], d[0]) + 0.01, std::atan2(-d[2], std::hypot(d[0], d[1])) - 0.02,
                                    NAN, NAN, NAN};
        Complaints out;
        const Measured m = linearize(*model, sample_of(z), ports, {}, out);
        REQUIRE_NO_COMPLAINTS(out);
        CHECK(std::abs(m.residual[0] - 0.01) < 1e-9);
        CHECK(std::abs(m.residual[1] + 0.02) < 1e-9);
        // Whoever turns to the right sees it further to the left.
        if (from == "car") CHECK(std::abs(m.H.back()(0, 0) + 1) < 1e-12);
        if (from == "north") {
          const Eigen::Vector3d east = is_geodetic ? Eigen::Vector3d::UnitY() : Eigen::Vector3d(C_en.col(1));
          CHECK((m.H[0] * east)(0) < -300.0 / (500 * 500) * 0.99);  // and whoever goes east
        }
        REQUIRE_NO_COMPLAINTS(check_measurement(*model, Bearing::spec(), sample_of(z), ports, {}, {1e-6}, 1e-12));
      }
}

TEST_CASE("bearing: a target that is a block on the earth, seen from one", "[aiding]") {
  const PositionKind geodetic;
  const auto model = bind<Bearing>({{{"sigma", 0.01}},
                                    {{"target", &geodetic}, {"observer", &geodetic}},
                                    {"observer_north", "observer_east", "observer_down"}});
  const Eigen::Vector3d lla(0.9, 0.2, 100), there = strapdown::position_plus(lla, {3000, 4000, -250});
  const PortStates ports{{&geodetic, {there[0], there[1], there[2]}, 1.0, 1e-8},
                         {&geodetic, {lla[0], lla[1], lla[2]}, 1.0, 1e-8}};
  REQUIRE_NO_COMPLAINTS(
      check_measurement(*model, Bearing::spec(), sample_of({0.9, 0.1, NAN, NAN, NAN}), ports, {}, {1e-6}, 1e-11));
}

TEST_CASE("bearing: what does not fit is refused when it is bound", "[aiding]") {
  const AdditiveKind two(2, "m"), three(3, "m"), heading("heading", 1, "rad");
  const PositionKind geodetic;
  const AttitudeKind attitude;
  const auto message = [](const Setup& setup) -> std::string {
    try {
      bind<Bearing>(setup);
    } catch (const ComponentError& error) {
      UNSCOPED_INFO(error.pointer() << ": " << error.what());
      return error.pointer() + ": " + error.what();
    }
    return "";
  };
  const std::vector<std::string> no_place{"observer_north", "observer_east", "observer_down"};
  const nlohmann::json plain{{"sigma", 0.1}},
      with_point{{"sigma", 0.1}, {"point", {{"north", 1}, {"east", 2}, {"down", 3}}}};
  CHECK(message({with_point, {{"observer", &three}}, no_place}).empty());
  CHECK(message({plain, {{"observer", &three}}, no_place}).find("/blocks: there is no target") == 0);
  CHECK(message({with_point, {{"observer", &three}, {"target", &three}}, no_place})
            .find("/point: a block is the target") == 0);
  CHECK(message({with_point, {}, no_place}).find("/blocks: nothing here is estimated") == 0);
  CHECK(message({with_point, {{"observer", &geodetic}}, no_place})
            .find("/point: local points (north, east, down) for a "
                  "place on the earth need an origin") == 0);
  CHECK(
      message({plain, {{"observer", &three}, {"target", &geodetic}}, no_place}).find("/blocks/observer: of observer") ==
      0);
  CHECK(message({plain, {{"target", &geodetic}}, {}}).find("/blocks: the target is on the earth") == 0);
  CHECK(message({plain, {{"observer", &two}, {"target", &two}, {"attitude", &attitude}}, {"elevation"}})
            .find("/blocks/attitude: directions from the deck") == 0);
  CHECK(message({plain, {{"observer", &three}, {"target", &three}, {"attitude", &attitude}, {"heading", &heading}}, {}})
            .find("/blocks/heading: an attitude has a heading") == 0);
}

TEST_CASE("bearing: what has no direction is refused", "[aiding]") {
  const AdditiveKind target(2, "m");
  const auto model = bind<Bearing>({{{"sigma", 0.01}}, {{"target", &target}}, {"elevation", "observer_down"}});
  const std::vector<double> here{5, 6}, there{50, 6};
  const auto refused = [&](const std::vector<double>& x, const std::vector<double>& z) {
    Complaints out;
    return linearize(*model, sample_of(z), {{&target, x, 10.0, 1e-8}}, {}, out).result.refusal;
  };
  CHECK(refused(here, {0.1, NAN, 5, 6, NAN}) == Refusal::unsupported);
  CHECK(refused(there, {NAN, NAN, 5, 6, NAN}) == Refusal::invalid);
  CHECK(refused(there, {0.1, NAN, NAN, 6, NAN}) == Refusal::invalid);
  const AdditiveKind four(4, "m");
  CHECK_THROWS_AS(bind<Bearing>({{{"sigma", 0.01}}, {{"target", &four}}, {"elevation"}}), ComponentError);
  CHECK_THROWS_AS(bind<Bearing>({{{"sigma", 0.01}}, {{"target", &target}}, {"elevation", "observer_east"}}),
                  ComponentError);
}

}  // namespace bearing_test
