// SPDX-License-Identifier: Apache-2.0
// Plugin aiding, what other sensors see of attitude, velocity and height: Jacobians by differences, the sign of each by a
// case that one can check in the head, refusals.
#include "../../plugins/aiding/attitude_fix.hpp"
#include "../../plugins/aiding/body_velocity.hpp"
#include "../../plugins/aiding/course.hpp"
#include "../../plugins/aiding/heading.hpp"
#include "../../plugins/aiding/height.hpp"
#include "../../plugins/aiding/magnetometer.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace aiding_test {

using namespace binnacle;
using namespace binnacle::aiding;
using namespace binnacle::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

constexpr double degree = M_PI / 180, none = NAN;

std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

SampleView sample_of(const std::vector<double>& fields) {
  SampleView sample;
  sample.t = 0;
  sample.fields = fields.data();
  return sample;
}

PortState attitude_state(const AttitudeKind& kind, const Vector3d& roll_pitch_yaw) {
  return {&kind, numbers(strapdown::quaternion_from_euler(roll_pitch_yaw)), 1e-2, 4e-16};
}

Measured see(const MeasurementModel& model, const std::vector<double>& z, const PortStates& ports) {
  Complaints out;
  const Measured m = linearize(model, sample_of(z), ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  return m;
}

Refusal refusal_of(const MeasurementModel& model, const std::vector<double>& z, const PortStates& ports) {
  const Measured m = see(model, z, ports);
  REQUIRE_FALSE(m.result);
  return m.result.refusal;
}

const Vector3d places[] = {{0, 0, 0}, {0.3, -0.2, -0.5}, {-2.9, 0.7, 3.1}, {1.2, -1.1, 2.0}};

}  // namespace

TEST_CASE("height: what is higher reads higher, geodetic and local", "[aiding]") {
  const PositionKind geodetic;
  const AdditiveKind local(3, "m"), bias(1, "m"), scale(1, "1");
  const Setup setup{{{"sigma", 0.5}, {"reference", 100}},
                    {{"position", &geodetic}, {"bias", &bias}, {"scale", &scale}},
                    {"height_sd"}};
  const auto model = bind<Height>(setup);
  const PortStates ports{{&geodetic, {0.9, 0.2, 160}, 10.0, 4e-9},
                         {&bias, {3}, 1.0, 1e-15},
                         {&scale, {0.01}, 1e-2, 1e-17}};
  const Measured m = see(*model, {170, none}, ports);
  REQUIRE(m.result);
  CHECK(std::abs(m.residual[0] - (170 - 160 - 3 - 0.6)) < 1e-12);
  CHECK(m.R(0, 0) == 0.25);
  CHECK(std::abs(m.H[0](0, 2) + 1.01) < 1e-15);  // a metre down is 1.01 less
  CHECK(m.H[1](0, 0) == 1);
  CHECK(m.H[2](0, 0) == 60);
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, Height::spec(), sample_of({170, none}), ports, {}, {1e-6}, 1e-8));

  const auto of_local = bind<Height>({{{"sigma", 0.5}}, {{"position", &local}}, {"height_sd"}});
  const Measured above = see(*of_local, {12, none}, {{&local, {5, 6, -10}, 1.0, 1e-15}, {}, {}});
  CHECK(above.residual[0] == 2);
  CHECK(above.H[0](0, 2) == -1);
}

TEST_CASE("height: the channel's own deviation, and what is none", "[aiding]") {
  const PositionKind geodetic;
  const auto model = bind<Height>({{}, {{"position", &geodetic}}, {}});
  const PortStates ports{{&geodetic, {0.9, 0.2, 160}, 10.0, 4e-9}, {}, {}};
  CHECK(see(*model, {160, 2}, ports).R(0, 0) == 4);
  for (const double sd : {0.0, -1.0, none, 1e200}) CHECK(refusal_of(*model, {160, sd}, ports) == Refusal::invalid);
  CHECK(refusal_of(*model, {none, 2}, ports) == Refusal::invalid);
  CHECK_THROWS_AS(bind<Height>({{}, {{"position", &geodetic}}, {"height_sd"}}), ComponentError);
  const AdditiveKind plane(2, "m");
  CHECK_THROWS_AS(bind<Height>({{{"sigma", 1}}, {{"position", &plane}}, {"height_sd"}}), ComponentError);
}

TEST_CASE("heading: of baselines on all sides, over the wrap, declination, bias", "[aiding]") {
  const AttitudeKind attitude;
  const AdditiveKind bias(1, "rad");
  struct Case {
    Vector3d baseline;
    double yaw, declination, heading;  // degrees
  };
  // The heading that is read, of a level vehicle.
  for (const Case& c : {Case{{1, 0, 0}, 30, 0, 30}, Case{{0, 1, 0}, 30, 0, 120}, Case{{0, -2, 0}, 30, 0, -60},
                        Case{{1, 0, 0}, 179.9, 0, 179.9}, Case{{0, 1, 0}, 100, 0, -170}, Case{{1, 0, 0}, 30, 5, 25}}) {
    CAPTURE(c.baseline.transpose(), c.yaw, c.declination);
    const auto model =
        bind<Heading>({{{"sigma", 0.01}, {"baseline", numbers(c.baseline)}, {"declination", c.declination * degree}},
                       {{"attitude", &attitude}, {"bias", &bias}},
                       {"heading_sd"}});
    const PortStates ports{attitude_state(attitude, {0, 0, c.yaw * degree}), {&bias, {0.02}, 1e-2, 1e-17}};
    const Measured m = see(*model, {std::remainder((c.heading + 3) * degree + 0.02, 2 * M_PI), none}, ports);
    REQUIRE(m.result);
    CHECK(std::abs(m.residual[0] - 3 * degree) < 1e-14);
    CHECK(std::abs(m.H[0](0, 2) - 1) < 1e-14);  // to the right by δ: more by δ
    CHECK(m.H[1](0, 0) == 1);
  }
}

TEST_CASE("heading: Jacobians of a vehicle askew, and a line that points up", "[aiding]") {
  const AttitudeKind attitude;
  const auto model =
      bind<Heading>({{{"sigma", 0.01}, {"baseline", {1, 0.3, -0.4}}}, {{"attitude", &attitude}}, {"heading_sd"}});
  for (const Vector3d& angles : places) {
    CAPTURE(angles.transpose());
    const PortStates ports{attitude_state(attitude, angles), {}};
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, Heading::spec(), sample_of({0.7, none}), ports, {}, {1e-6}, 1e-13));
  }
  const auto nose = bind<Heading>({{{"sigma", 0.01}}, {{"attitude", &attitude}}, {"heading_sd"}});
  CHECK(refusal_of(*nose, {0.7, none}, {attitude_state(attitude, {0, 85 * degree, 0}), {}}) == Refusal::unsupported);
  CHECK(see(*nose, {0.7, none}, {attitude_state(attitude, {0, 75 * degree, 0}), {}}).result);
  CHECK(refusal_of(*nose, {none, none}, {attitude_state(attitude, {0, 0, 0}), {}}) == Refusal::invalid);
  CHECK_THROWS_AS(bind<Heading>(
                      {{{"sigma", 0.01}, {"baseline", {0, 0, 0}}}, {{"attitude", &attitude}}, {"heading_sd"}}),
                  ComponentError);
}

TEST_CASE("course: to all sides, less believed when slow, refused when slower", "[aiding]") {
  const AdditiveKind velocity("velocity.ned", 3, "m/s");
  const auto model = bind<Course>(
      {{{"sigma", 0.01}, {"velocity_sigma", 0.1}, {"min_speed", 2}}, {{"velocity", &velocity}}, {"course_sd"}});
  for (const double course : {0.0, 45.0, 90.0, 179.9, -179.9, -90.0}) {
    CAPTURE(course);
    const double c = course * degree;
    const PortStates ports{{&velocity, {5 * std::cos(c), 5 * std::sin(c), 3}, 1e-2, 1e-15}};
    const std::vector<double> z{std::remainder(c + 0.05, 2 * M_PI), none};
    const Measured m = see(*model, z, ports);
    REQUIRE(m.result);
    CHECK(std::abs(m.residual[0] - 0.05) < 1e-14);
    CHECK(std::abs(m.R(0, 0) - (1e-4 + 4e-4)) < 1e-16);
    const Vector3d right(-std::sin(c), std::cos(c), 0);
    CHECK(std::abs((m.H[0] * right)(0) - 0.2) < 1e-14);  // a metre a second to the right of five
    CHECK(m.H[0](0, 2) == 0);
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, Course::spec(), sample_of(z), ports, {}, {1e-6}, 1e-13));
  }
  // The vertical velocity does not count.
  CHECK(refusal_of(*model, {0, none}, {{&velocity, {1.9, 0, 40}, 1.0, 1e-15}}) == Refusal::unsupported);
  CHECK(refusal_of(*model, {none, none}, {{&velocity, {5, 0, 0}, 1.0, 1e-15}}) == Refusal::invalid);
}

namespace {

const nlohmann::json north_of_kiel = {{"declination", 0.06},
                                      {"inclination", 1.2},
                                      {"strength", 50e-6},
                                      {"sigma", 0.25e-6}};
const std::vector<std::string> no_map = {"mx_sd", "my_sd", "mz_sd", "field"};

}  // namespace

TEST_CASE("magnetometer: where the field points, by hand", "[aiding]") {
  const AttitudeKind attitude;
  const AdditiveKind hard(3, "T");
  // Due north, 60° down: of a vehicle that heads east the field's north is to the left, of one on its nose behind.
  nlohmann::json parameters = {{"declination", 0}, {"inclination", 60 * degree}, {"strength", 2e-5}, {"sigma", 1e-7}};
  const auto model = bind<Magnetometer>({parameters, {{"attitude", &attitude}, {"hard_iron", &hard}}, no_map});
  const double down = 2e-5 * std::sqrt(0.75);
  struct Case {
    Vector3d angles, b;
  };
  for (const Case& c : {Case{{0, 0, 0}, {1e-5, 0, down}}, Case{{0, 0, 90}, {0, -1e-5, down}},
                        Case{{0, 90, 0}, {-down, 0, 1e-5}}, Case{{90, 0, 0}, {1e-5, down, 0}}}) {
    CAPTURE(c.angles.transpose());
    const PortStates ports{attitude_state(attitude, c.angles * degree), {&hard, {1e-6, 2e-6, -3e-6}, 1e-7, 1e-21}, {}};
    const Vector3d z = c.b + Vector3d(1e-6, 2e-6, -3e-6) + Vector3d(1e-8, 2e-8, 3e-8);
    const Measured m = see(*model, {z[0], z[1], z[2], none, none, none}, ports);
    REQUIRE(m.result);
    CHECK((m.residual - Vector3d(1e-8, 2e-8, 3e-8)).norm() < 1e-18);
    CHECK(m.H[1] == Matrix3d::Identity());
  }
  // Declination to the east: of a vehicle that heads north the field is to the right.
  parameters["declination"] = 0.1;
  const auto east = bind<Magnetometer>({parameters, {{"attitude", &attitude}}, no_map});
  const Measured m = see(*east, {0, 0, 0, none, none, none}, {attitude_state(attitude, {0, 0, 0}), {}, {}});
  CHECK(m.residual[1] < -0.9e-6);
  CHECK(m.H[0](1, 2) < 0);  // turned to the right, it is less to the right
}

TEST_CASE("magnetometer: Jacobians, with soft iron of three, six and nine components", "[aiding]") {
  const AttitudeKind attitude;
  const AdditiveKind hard(3, "T");
  for (const int size : {3, 6, 9}) {
    CAPTURE(size);
    const AdditiveKind soft(size, "1");
    nlohmann::json parameters = north_of_kiel;
    parameters["soft_iron"] = {{1.1, 0.02, 0.03}, {-0.04, 0.9, 0.01}, {0.02, 0.05, 1.05}};
    parameters["hard_iron"] = {1e-6, -2e-6, 5e-7};
    const auto model =
        bind<Magnetometer>({parameters, {{"attitude", &attitude}, {"hard_iron", &hard}, {"soft_iron", &soft}}, no_map});
    std::vector<double> s;
    for (int i = 0; i < size; ++i) s.push_back(0.01 * (i + 1));
    for (const Vector3d& angles : places) {
      const PortStates ports{attitude_state(attitude, angles),
                             {&hard, {1e-6, 2e-6, -3e-6}, 1e-6, 1e-21},
                             {&soft, s, 1e-2, 1e-17}};
      REQUIRE_NO_COMPLAINTS(check_measurement(*model, Magnetometer::spec(),
                                              sample_of({1e-5, 2e-5, 3e-5, none, none, none}), ports, {}, {1e-6},
                                              1e-19));
    }
  }
}

TEST_CASE("magnetometer: nine components are a matrix row by row, six a symmetric one", "[aiding]") {
  const AttitudeKind attitude;
  const AdditiveKind six(6, "1"), nine(9, "1");
  const Vector3d field(1e-5, 2e-5, 4e-5);
  const nlohmann::json parameters = {{"field", numbers(field)}, {"sigma", 1e-7}};
  const auto seen = [&](const AdditiveKind& soft, const std::vector<double>& s) {
    const auto model = bind<Magnetometer>({parameters, {{"attitude", &attitude}, {"soft_iron", &soft}}, no_map});
    return Vector3d(
        -see(*model, {0, 0, 0, none, none, none}, {attitude_state(attitude, {0, 0, 0}), {}, {&soft, s, 1e-2, 1e-17}})
             .residual);
  };
  Matrix3d S;
  S << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9;
  CHECK((seen(nine, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}) - (Matrix3d::Identity() + S) * field).norm() <
        1e-19);
  S << 0.1, 0.4, 0.5, 0.4, 0.2, 0.6, 0.5, 0.6, 0.3;
  CHECK((seen(six, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6}) - (Matrix3d::Identity() + S) * field).norm() < 1e-19);
}

TEST_CASE("magnetometer: a field that a channel gives, and what is refused", "[aiding]") {
  const AttitudeKind attitude;
  const auto model = bind<Magnetometer>({{{"sigma", 1e-7}}, {{"attitude", &attitude}}, {"mx_sd", "my_sd", "mz_sd"}});
  const PortStates ports{attitude_state(attitude, {0, 0, 0}), {}, {}};
  const std::vector<double> z{1e-5, 2e-5, 4e-5, none, none, none}, field{1e-5, 1e-5, 4e-5};
  SampleView map[1] = {sample_of(field)};
  const auto with_map = [&] {
    Complaints out;
    const Measured m = linearize(*model, sample_of(z), ports, {}, out, map);
    REQUIRE_NO_COMPLAINTS(out);
    return m;
  };
  CHECK(with_map().result.refusal == Refusal::unsupported);
  map[0].available = true;
  const Measured m = with_map();
  REQUIRE(m.result);
  CHECK((m.residual - Vector3d(0, 1e-5, 0)).norm() < 1e-19);

  const auto fails = [&](nlohmann::json parameters, std::vector<std::string> without = no_map) {
    parameters["sigma"] = 1e-7;
    CHECK_THROWS_AS(bind<Magnetometer>({parameters, {{"attitude", &attitude}}, without}), ComponentError);
  };
  fails({});
  fails({{"declination", 0.1}, {"inclination", 1}});
  fails({{"declination", 0.1}, {"inclination", 1}, {"strength", 5e-5}, {"field", {1e-5, 0, 4e-5}}});
  fails({{"field", {1e-5, 0, 4e-5}}}, {"mx_sd", "my_sd", "mz_sd"});
  const AdditiveKind four(4, "1");
  CHECK_THROWS_AS(bind<Magnetometer>({north_of_kiel, {{"attitude", &attitude}, {"soft_iron", &four}}, no_map}),
                  ComponentError);
}

namespace {

const std::vector<std::string> no_sd = {"north_sd", "east_sd", "down_sd"};

/// qw … qz, c11 … c33, roll, pitch, yaw, deviations.
std::vector<double> fix_of(const Vector3d& angles) {
  std::vector<double> z = numbers(strapdown::quaternion_from_euler(angles));
  const Matrix3d C = (Eigen::AngleAxisd(angles[2], Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(angles[1], Vector3d::UnitY()) * Eigen::AngleAxisd(angles[0], Vector3d::UnitX()))
                         .toRotationMatrix();
  for (int i = 0; i < 9; ++i) z.push_back(C(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) z.push_back(angles[i]);
  z.insert(z.end(), 3, none);
  return z;
}

}  // namespace

TEST_CASE("attitude_fix: three forms of one attitude, on the manifold", "[aiding]") {
  const AttitudeKind attitude;
  for (const std::string form : {"quaternion", "dcm", "angles"}) {
    CAPTURE(form);
    const auto model =
        bind<AttitudeFix>({{{"sigma", {0.01, 0.02, 0.03}}, {"form", form}}, {{"attitude", &attitude}}, no_sd});
    // Two degrees to the right of the estimate, over the wrap.
    const Measured m = see(*model, fix_of({0, 0, -179 * degree}), {attitude_state(attitude, {0, 0, 179 * degree})});
    REQUIRE(m.result);
    CHECK((m.residual - Vector3d(0, 0, 2 * degree)).norm() < 1e-14);
    CHECK(m.R.isApprox(Vector3d(1e-4, 4e-4, 9e-4).asDiagonal().toDenseMatrix()));
    // Nose up by 0.1 of a vehicle that heads east: about the axis that points south.
    const Measured up = see(*model, fix_of({0, 0.1, M_PI / 2}), {attitude_state(attitude, {0, 0, M_PI / 2})});
    CHECK((up.residual - Vector3d(-0.1, 0, 0)).norm() < 1e-14);
    for (const Vector3d& angles : places) {
      const PortStates ports{attitude_state(attitude, angles)};
      const std::vector<double> z = fix_of(angles + Vector3d(0.2, -0.1, 0.3));
      REQUIRE_NO_COMPLAINTS(check_measurement(*model, AttitudeFix::spec(), sample_of(z), ports, {}, {1e-6}, 1e-13));
      const Measured far = see(*model, z, ports);
      CHECK((far.H[0] * far.residual - far.residual).norm() < 1e-14);
    }
  }
}

TEST_CASE("attitude_fix: which form, and what is no attitude", "[aiding]") {
  const AttitudeKind attitude;
  const Ports ports{{"attitude", &attitude}};
  const PortStates level{attitude_state(attitude, {0, 0, 0})};
  std::vector<std::string> angles_only = no_sd, nothing = no_sd;
  for (const char* name : {"qw", "qx", "qy", "qz", "c11", "c12", "c13", "c21", "c22", "c23", "c31", "c32", "c33"})
    angles_only.push_back(name), nothing.push_back(name);
  nothing.push_back("yaw");
  CHECK(see(*bind<AttitudeFix>({{{"sigma", 0.01}}, ports, angles_only}), fix_of({0, 0, 0.1}), level).residual[2] >
        0.09);
  CHECK_THROWS_AS(bind<AttitudeFix>({{{"sigma", 0.01}}, ports, nothing}), ComponentError);
  CHECK_THROWS_AS(bind<AttitudeFix>({{{"sigma", 0.01}}, ports, no_sd}), ComponentError);  // all three: which?
  CHECK_THROWS_AS(bind<AttitudeFix>({{{"sigma", 0.01}, {"form", "dcm"}}, ports, angles_only}), ComponentError);
  const auto refused = [&](const char* form, std::size_t field, double value) {
    std::vector<double> z = fix_of({0.1, 0.2, 0.3});
    z[field] = value;
    return refusal_of(*bind<AttitudeFix>({{{"sigma", 0.01}, {"form", form}}, ports, no_sd}), z, level);
  };
  CHECK(refused("quaternion", 0, 0.5) == Refusal::invalid);
  CHECK(refused("quaternion", 2, none) == Refusal::invalid);
  CHECK(refused("dcm", 4, -1) == Refusal::invalid);
  CHECK(refused("angles", 13, none) == Refusal::invalid);
  std::vector<double> mirrored = fix_of({0, 0, 0});
  mirrored[12] = -1;  // c33: left-handed axes
  CHECK(refusal_of(*bind<AttitudeFix>({{{"sigma", 0.01}, {"form", "dcm"}}, ports, no_sd}), mirrored, level) ==
        Refusal::invalid);
}

namespace {

struct Moving {
  AdditiveKind velocity{"velocity.ned", 3, "m/s"}, zeta{3, "rad"}, one{1, "1"}, three{3, "1"};
  AttitudeKind attitude;
};
const std::vector<std::string> no_velocity_sd = {"vx_sd", "vy_sd", "vz_sd"};

}  // namespace

TEST_CASE("body_velocity: forward, right and down, by hand", "[aiding]") {
  const Moving b;
  const auto model = bind<BodyVelocity>(
      {{{"sigma", {0.1, 0.2, 0.3}}, {"relative", 0.1}},
       {{"velocity", &b.velocity}, {"attitude", &b.attitude}, {"misalignment", &b.zeta}, {"scale", &b.one}},
       no_velocity_sd});
  // Heading east at 2 m/s to the east, 1 to the south, 0.5 down: forward 2, right 1.
  PortStates ports{{&b.velocity, {-1, 2, 0.5}, 1.0, 1e-15},
                   attitude_state(b.attitude, {0, 0, M_PI / 2}),
                   {&b.zeta, {0, 0, 0}, 1e-2, 1e-16},
                   {&b.one, {0.1}, 1e-2, 1e-17}};
  const Measured m = see(*model, {2.2, 1.1, 0.55, none, none, none}, ports);
  REQUIRE(m.result);
  CHECK(m.residual.norm() < 1e-14);
  const double relative = 0.01 * (2.2 * 2.2 + 1.1 * 1.1 + 0.55 * 0.55);
  CHECK((m.R.diagonal() - Vector3d(0.01 + relative, 0.04 + relative, 0.09 + relative)).norm() < 1e-14);
  CHECK((m.H[0].col(1) - Vector3d(1.1, 0, 0)).norm() < 1e-14);  // more to the east: faster forward
  CHECK((m.H[3].col(0) - Vector3d(2, 1, 0.5)).norm() < 1e-14);
  // Turned to the right, the vehicle sees its velocity more from the left.
  CHECK(m.H[1](1, 2) < -2);
  // v_v = v_b + ζ × v_b: about down to the right, what is forward comes to lie on the right.
  CHECK(std::abs(m.H[2](1, 2) - 2.2) < 1e-14);
}

TEST_CASE("body_velocity: Jacobians, of three axes or of one, one scale or three", "[aiding]") {
  const Moving b;
  for (const AdditiveKind* scale : {&b.one, &b.three})
    for (const std::vector<std::string>& lacking : {std::vector<std::string>{}, {"vy", "vz"}, {"vx"}}) {
      std::vector<std::string> without = no_velocity_sd;
      without.insert(without.end(), lacking.begin(), lacking.end());
      const auto model = bind<BodyVelocity>(
          {{{"sigma", {0.1, 0.2, 0.3}}},
           {{"velocity", &b.velocity}, {"attitude", &b.attitude}, {"misalignment", &b.zeta}, {"scale", scale}},
           without});
      REQUIRE(model->declaration().max_rows == 3 - static_cast<int>(lacking.size()));
      const std::vector<double> s = scale == &b.one ? std::vector<double>{0.1} : std::vector<double>{0.1, -0.2, 0.3};
      const PortStates ports{{&b.velocity, {12, -9, 1.5}, 1.0, 1e-15},
                             attitude_state(b.attitude, {0.3, -0.2, -0.5}),
                             {&b.zeta, {0.2, -0.3, 0.25}, 1e-2, 1e-16},
                             {scale, s, 1e-2, 1e-17}};
      REQUIRE_NO_COMPLAINTS(check_measurement(*model, BodyVelocity::spec(), sample_of({11, 2, 1, none, none, none}),
                                              ports, {}, {1e-6}, 1e-12));
    }
}

TEST_CASE("body_velocity: an axis that is not there is not needed, one that is must be a number", "[aiding]") {
  const Moving b;
  const Ports ports{{"velocity", &b.velocity}, {"attitude", &b.attitude}};
  const PortStates states{{&b.velocity, {3, 0, 0}, 1.0, 1e-15}, attitude_state(b.attitude, {0, 0, 0}), {}, {}};
  const auto wheel = bind<BodyVelocity>({{{"sigma", 0.1}}, ports, {"vy", "vz", "vx_sd", "vy_sd", "vz_sd"}});
  const Measured m = see(*wheel, {3.5, none, none, none, none, none}, states);
  REQUIRE(m.result);
  CHECK(std::abs(m.residual[0] - 0.5) < 1e-14);
  CHECK(refusal_of(*wheel, {none, 0, 0, none, none, none}, states) == Refusal::invalid);
  const auto log = bind<BodyVelocity>({{{"sigma", 0.1}}, ports, {"vx_sd", "vy_sd", "vz_sd"}});
  CHECK(refusal_of(*log, {3, none, 0, none, none, none}, states) == Refusal::invalid);
  CHECK_THROWS_AS(bind<BodyVelocity>({{{"sigma", 0.1}}, ports, {"vx", "vy", "vz"}}), ComponentError);
  const AdditiveKind two(2, "1");
  CHECK_THROWS_AS(bind<BodyVelocity>({{{"sigma", 0.1}},
                                      {{"velocity", &b.velocity}, {"attitude", &b.attitude}, {"scale", &two}},
                                      no_velocity_sd}),
                  ComponentError);
}

}  // namespace aiding_test
