// SPDX-License-Identifier: Apache-2.0
// Plugin frames: lever arms, mounted attitudes, turned axes.
#include <cmath>

#include "../../plugins/frames/lever_arm.hpp"
#include "../../plugins/frames/lever_arm_velocity.hpp"
#include "../../plugins/frames/mounted_attitude.hpp"
#include "../../plugins/frames/mounting.hpp"
#include "../../plugins/frames/rotate_axes.hpp"
#include "binnacle/testing.hpp"

#include <Eigen/Geometry>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace frames_test {

using namespace binnacle;
using namespace binnacle::frames;
using namespace binnacle::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

constexpr double degree = M_PI / 180;

std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

struct Place {
  const char* name;
  Vector3d lla, v_n, roll_pitch_yaw, omega;
};
const Place places[] = {
    {"a car", {0.65, 2.2, 60}, {8, -5, 0.1}, {0.02, -0.03, 2.5}, {0.05, -0.1, 0.6}},
    {"a fast aircraft", {0.8, -1.3, 11000}, {180, 170, -4}, {0.9, 0.2, 0.75}, {0.8, 0.3, -0.2}},
    {"the southern hemisphere", {-0.59, 2.6, 400}, {-12, 30, 1}, {-0.2, 0.1, -1.9}, {-0.3, 0.2, 0.1}},
    {"a high latitude", {1.45, -3.1, 5}, {3, 4, 0}, {0.1, 0.02, 3.1}, {0.01, 0.02, -0.05}},
    {"upside down", {0.1, 0.3, 3000}, {100, -90, 20}, {3.0, -0.6, -2.7}, {-1.5, 0.7, 0.4}},
};

PortState position_state(const PositionKind& kind, const Place& place) {
  return {&kind, numbers(place.lla), 10.0, 4e-9};
}
PortState attitude_state(const AttitudeKind& kind, const Place& place) {
  return {&kind, numbers(strapdown::quaternion_from_euler(place.roll_pitch_yaw)), 1e-2, 4e-16};
}

template <int Size>
Eigen::Matrix<double, Size, 1> value_of(const DerivedBlock& model, const PortStates& ports, const Driving& u) {
  Eigen::Matrix<double, Size, 1> value;
  const auto x = test::detail::pointers(ports);
  DerivedOutput out{{value.data(), Size}, {}};
  REQUIRE(model.evaluate({x.data(), u}, out));
  return value;
}

}  // namespace

TEST_CASE("lever arm: Jacobians and geometry", "[frames]") {
  const PositionKind position;
  const AttitudeKind attitude;
  const AdditiveKind lever_arm(3, "m");
  const auto model = bind<LeverArm>({{{"lever_arm", {1.5, -0.4, -2.0}}},
                                     {{"position", &position}, {"attitude", &attitude}, {"lever_arm", &lever_arm}},
                                     {}});
  for (const Place& place : places) {
    INFO(place.name);
    const PortStates ports{position_state(position, place),
                           attitude_state(attitude, place),
                           {&lever_arm, {0.1, 0.2, -0.3}, 0.1, 1e-15}};
    // |l| tan(lat)/R: the meridians converge between the two points.
    const double convergence = 3 * (1 + std::abs(std::tan(place.lla[0]))) / 6.36e6;
    REQUIRE_NO_COMPLAINTS(check_derived(*model, LeverArm::spec(), position, ports, {}, {convergence + 1e-7}, 4e-9));

    const Vector3d l{1.6, -0.2, -2.3};
    const Matrix3d C_nb = strapdown::dcm_from_quaternion(vector_at<4>(ports[1].x.data()));
    const Vector3d chord =
        strapdown::ecef_from_lla(value_of<3>(*model, ports, {})) - strapdown::ecef_from_lla(place.lla);
    const Vector3d chord_n = strapdown::C_en(place.lla[0], place.lla[1]).transpose() * chord;
    REQUIRE((chord_n - C_nb * l).norm() < 1e-5);
  }
}

TEST_CASE("lever arm: the lever_arm is a parameter, a block or both, but not nothing", "[frames]") {
  const PositionKind position;
  const AttitudeKind attitude;
  const AdditiveKind lever_arm(3, "m");
  const Ports two{{"position", &position}, {"attitude", &attitude}};
  Ports three = two;
  three["lever_arm"] = &lever_arm;
  const PortState at{&position, {0.5, 0.5, 0}}, level{&attitude, {1, 0, 0, 0}};
  const auto height = [&](const Setup& setup, const PortState& third) {
    return value_of<3>(*bind<LeverArm>(setup), {at, level, third}, {})[2];
  };
  REQUIRE(std::abs(height({{{"lever_arm", {0, 0, -2}}}, two, {}}, {}) - 2) < 1e-12);
  REQUIRE(std::abs(height({{}, three, {}}, {&lever_arm, {0, 0, -1}}) - 1) < 1e-12);
  REQUIRE(std::abs(height({{{"lever_arm", {0, 0, -2}}}, three, {}}, {&lever_arm, {0, 0, -1}}) - 3) < 1e-12);
  REQUIRE(bind<LeverArm>({{{"lever_arm", {0, 0, -2}}}, two, {}})->declaration().read_ports.size() == 2);
  REQUIRE_THROWS_AS(bind<LeverArm>({{}, two, {}}), ComponentError);
  REQUIRE_THROWS_AS(bind<LeverArmVelocity>({{}, {{"velocity", &lever_arm}, {"attitude", &attitude}}, {}}),
                    ComponentError);
}

TEST_CASE("lever arm velocity: Jacobians", "[frames]") {
  const PositionKind position;
  const AttitudeKind attitude;
  const AdditiveKind velocity("velocity.ned", 3, "m/s"), lever_arm(3, "m"), bias(3, "rad/s"), scale(3, "1");
  const Setup all{{{"lever_arm", {1.5, -0.4, -2.0}}},
                  {{"velocity", &velocity},
                   {"attitude", &attitude},
                   {"position", &position},
                   {"gyro_bias", &bias},
                   {"gyro_scale", &scale},
                   {"lever_arm", &lever_arm}},
                  {}};
  Setup least = all;
  for (const char* open : {"position", "gyro_bias", "gyro_scale", "lever_arm"}) least.ports.erase(open);
  for (const Place& place : places) {
    INFO(place.name);
    // The earth's rate is small: weighed up by turning slowly, so that its part of the attitude block is seen.
    for (const double share : {1.0, 1e-4}) {
      const Vector3d omega = share * place.omega;
      const Driving context{0, omega.data()};
      PortStates ports{{&velocity, numbers(place.v_n), 1.0, 1e-13},
                       attitude_state(attitude, place),
                       {&position, numbers(place.lla), 1e4, 4e-9},
                       {&bias, numbers(0.01 * share * Vector3d(1, -2, 3)), 1e-2, 1e-16},
                       {&scale, {0.01, -0.02, 0.03}, 1e-2, 1e-16},
                       {&lever_arm, {0.1, 0.2, -0.3}, 0.1, 1e-15}};
      const auto model = bind<LeverArmVelocity>(all);
      REQUIRE(model->declaration().read_ports.size() == 6);
      REQUIRE_NO_COMPLAINTS(check_derived(*model, LeverArmVelocity::spec(), velocity, ports, context, {2e-5}, 4e-14));
      ports[2] = ports[3] = ports[4] = ports[5] = {};
      REQUIRE_NO_COMPLAINTS(check_derived(*bind<LeverArmVelocity>(least), LeverArmVelocity::spec(), velocity, ports,
                                          context, {1e-7}, 4e-14));
    }
  }
}

TEST_CASE("lever arm velocity: a turntable, a body at rest on the earth, the path of the point", "[frames]") {
  const PositionKind position;
  const AttitudeKind attitude;
  const AdditiveKind velocity("velocity.ned", 3, "m/s");
  const Setup setup{{{"lever_arm", {2.0, 0.0, -1.0}}},
                    {{"velocity", &velocity}, {"attitude", &attitude}, {"position", &position}},
                    {}};
  const auto model = bind<LeverArmVelocity>(setup);
  const PortState none{};
  DerivedOutput nowhere;
  REQUIRE(model->evaluate({}, nowhere).refusal == Refusal::unsupported);

  for (const Place& place : places) {
    INFO(place.name);
    const Vector4d q = strapdown::quaternion_from_euler(place.roll_pitch_yaw);
    const Matrix3d C_nb = strapdown::dcm_from_quaternion(q);
    const Vector3d omega_ie_n = strapdown::omega_ie_n(place.lla[0]);
    const PortState at = position_state(position, place), attitude_at = attitude_state(attitude, place);
    const auto moving = [&](const Vector3d& v_n, const Vector3d& omega_ib_b) {
      const Driving context{0, omega_ib_b.data()};
      return Vector3d(value_of<3>(*model, {{&velocity, numbers(v_n)}, attitude_at, at, none, none, none}, context));
    };
    const Vector3d earth_b = C_nb.transpose() * omega_ie_n;
    REQUIRE(moving(Vector3d::Zero(), earth_b).norm() < 1e-17);
    const Vector3d turning = earth_b + C_nb.transpose() * Vector3d(0, 0, 1);
    REQUIRE((moving(Vector3d::Zero(), turning) - Vector3d(0, 0, 1).cross(C_nb * Vector3d(2, 0, -1))).norm() < 1e-14);

    // Two instants of the mechanization, dt apart around the middle: the chord of the point's path in ECEF.
    const double dt = 1e-3;
    const Vector3d f_b = C_nb.transpose() * Vector3d(0.3, -0.2, -9.8);
    const strapdown::Navigation start{place.lla, place.v_n, q};
    const auto after = strapdown::advance(start, {dt, place.omega * dt, f_b * dt, 0, 0});
    const auto middle = strapdown::advance(start, {dt / 2, place.omega * dt / 2, f_b * dt / 2, 0, 0});
    const auto point = [](const strapdown::Navigation& nav) -> Vector3d {
      const Matrix3d C_en = strapdown::C_en(nav.lla[0], nav.lla[1]);
      return C_en * (strapdown::dcm_from_quaternion(nav.q_nb) * Vector3d(2, 0, -1));
    };
    const Vector3d chord = (point(after) - point(start)) / dt;
    const Matrix3d C_ne = strapdown::C_en(middle.lla[0], middle.lla[1]).transpose();
    const Driving context{0, place.omega.data()};
    const Vector3d relative = value_of<3>(
        *model,
        {{&velocity, {0, 0, 0}}, {&attitude, numbers(middle.q_nb)}, {&position, numbers(middle.lla)}, none, none, none},
        context);
    REQUIRE((C_ne * chord - relative).norm() < 3e-6);  // earth and transport rate are 1e-4 to 4e-4 m/s here
  }
}

TEST_CASE("mounted attitude: Jacobians", "[frames]") {
  const AttitudeKind attitude;
  const AdditiveKind misalignment(3, "rad");
  const Setup setup{{{"roll", 0.3}, {"pitch", -1.1}, {"yaw", 2.0}, {"flip", "flu_to_frd"}},
                    {{"attitude", &attitude}, {"misalignment", &misalignment}},
                    {}};
  for (const Place& place : places)
    for (const double size : {0.0, 1e-9, 0.02, 0.8}) {
      INFO(place.name << ", misalignment " << size);
      const PortStates ports{attitude_state(attitude, place),
                             {&misalignment, {size, -2 * size, 0.5 * size}, 1e-2, 4e-16}};
      REQUIRE_NO_COMPLAINTS(
          check_derived(*bind<MountedAttitude>(setup), MountedAttitude::spec(), attitude, ports, {}, {1e-8}, 1e-15));
      Setup fixed = setup;
      fixed.ports.erase("misalignment");
      REQUIRE_NO_COMPLAINTS(check_derived(*bind<MountedAttitude>(fixed), MountedAttitude::spec(), attitude,
                                          {ports[0], {}}, {}, {1e-8}, 1e-15));
    }
}

TEST_CASE("mounted attitude: paper 001 (7), and the angles of a mount", "[frames]") {
  const AttitudeKind attitude;
  const AdditiveKind misalignment(3, "rad");
  const Vector4d q_nb = strapdown::quaternion_from_euler({0.1, -0.2, 0.7});
  const PortState body{&attitude, numbers(q_nb)};
  const Matrix3d C_bn = strapdown::dcm_from_quaternion(q_nb).transpose();

  const auto aligned = bind<MountedAttitude>({{}, {{"attitude", &attitude}, {"misalignment", &misalignment}}, {}});
  const Vector3d zeta{3e-5, -1e-5, 2e-5};
  const Matrix3d C_bv =
      C_bn * strapdown::dcm_from_quaternion(value_of<4>(*aligned, {body, {&misalignment, numbers(zeta)}}, {}));
  const Vector3d v_b = C_bv * Vector3d(20, 0, 0);
  REQUIRE(std::abs(v_b[1] + zeta[2] * 20) < 1e-8);
  REQUIRE(std::abs(v_b[2] - zeta[1] * 20) < 1e-8);

  // A sensor turned by +90 deg about down in its vehicle: its x axis points to the right, so the vehicle points west.
  const auto turned = bind<MountedAttitude>({{{"yaw", 90 * degree}}, {{"attitude", &attitude}}, {}});
  const PortState north{&attitude, {1, 0, 0, 0}};
  const Vector3d vehicle = strapdown::euler_from_quaternion(value_of<4>(*turned, {north, {}}, {}));
  REQUIRE((vehicle - Vector3d(0, 0, -90 * degree)).norm() < 1e-12);
}

namespace {

binnacle::testing::Emitted turned_by(const RotateAxes& model, std::size_t input, const SampleView& sample) {
  static const ComponentSpec spec = RotateAxes::spec();
  const auto made = binnacle::testing::TransformCaller(model, spec).on(input, sample, nullptr);
  REQUIRE(made.damage.empty());
  REQUIRE(made.samples.size() == 1);
  REQUIRE(made.samples[0].channel == static_cast<int>(input));
  return made.samples[0];
}

}  // namespace

TEST_CASE("rotate axes: the same as the mounted attitude, and the interval goes with it", "[frames]") {
  const nlohmann::json mount{{"roll", 170.79 * degree},
                             {"pitch", 60.5 * degree},
                             {"yaw", 167.45 * degree},
                             {"flip", "flu_to_frd"}};
  const auto model = bind<RotateAxes>({mount, {}, {}});
  REQUIRE(model->declaration().channels.size() == 2);
  REQUIRE(model->declaration().channels[0].name.empty());
  REQUIRE(model->declaration().channels[0].fields.size() == 6);
  REQUIRE(model->declaration().channels[0].fields[0].kind == FieldKind::rate);
  REQUIRE(model->declaration().memory_bytes == 0);

  // Written out: Rz Ry Rx to forward-left-up, then y and z reversed.
  const Matrix3d C = Vector3d(1, -1, -1).asDiagonal() * (Eigen::AngleAxisd(167.45 * degree, Vector3d::UnitZ()) *
                                                         Eigen::AngleAxisd(60.5 * degree, Vector3d::UnitY()) *
                                                         Eigen::AngleAxisd(170.79 * degree, Vector3d::UnitX()))
                                                            .toRotationMatrix();
  const double raw[6] = {0.1, -0.2, 0.3, 1.0, -2.0, 9.0};
  SampleView sample;
  sample.t0 = 100;
  sample.t = 200;
  sample.fields = raw;
  const auto out = turned_by(*model, 0, sample);
  REQUIRE(out.t0 == 100);
  REQUIRE(out.t == 200);
  REQUIRE((vector_at<3>(out.fields.data()) - C * Vector3d(0.1, -0.2, 0.3)).norm() < 1e-15);
  REQUIRE((vector_at<3>(out.fields.data() + 3) - C * Vector3d(1, -2, 9)).norm() < 1e-14);

  // Attitude of the turned axes, by the derived block with the same angles: n from raw = n from turned, C.
  const AttitudeKind attitude;
  const auto mounted = bind<MountedAttitude>({mount, {{"attitude", &attitude}}, {}});
  const Vector4d q = strapdown::quaternion_from_euler({0.4, 0.3, 0.2});
  const Matrix3d C_nv = strapdown::dcm_from_quaternion(value_of<4>(*mounted, {{&attitude, numbers(q)}, {}}, {}));
  REQUIRE((C_nv * C - strapdown::dcm_from_quaternion(q)).norm() < 1e-14);

  const auto none = bind<RotateAxes>({});
  REQUIRE((vector_at<6>(turned_by(*none, 0, sample).fields.data()) - vector_at<6>(raw)).norm() < 1e-15);
}

TEST_CASE("rotate axes: turning recorded samples by -10 mrad about z adds 10 mrad to the misalignment", "[frames]") {
  const double added = 10e-3;
  const auto model = bind<RotateAxes>({{{"yaw", -added}}, {}, {}});
  REQUIRE(model->declaration().channels[1].name == "truth");
  const Vector3d zeta{0, -10.7e-3, 1e-3}, euler{0.02, -0.03, 2.5};
  std::vector<double> fields = numbers(euler);
  fields.insert(fields.end(), zeta.data(), zeta.data() + 3);
  SampleView truth;
  truth.t = 7;
  truth.fields = fields.data();
  const auto out = turned_by(*model, 1, truth);
  REQUIRE(out.t == 7);
  const Vector3d turned = vector_at<3>(out.fields.data() + 3);
  REQUIRE((turned - Vector3d(0, -10.7e-3, 11e-3)).norm() < 1e-4);

  // Paper 001 (6), (7): a vehicle that drives along its x axis, in the axes of the sensor before and after.
  const Vector3d v_b = strapdown::dcm_from_quaternion(strapdown::quaternion_exp(-zeta)).col(0);
  const Vector3d v_turned = strapdown::dcm_from_quaternion(strapdown::quaternion_exp(-turned)).col(0);
  const double imu[6] = {v_b[0], v_b[1], v_b[2], 0, 0, 0};
  SampleView sample;
  sample.fields = imu;
  const Vector3d euler_turned = vector_at<3>(out.fields.data());
  REQUIRE((vector_at<3>(turned_by(*model, 0, sample).fields.data()) - v_turned).norm() < 1e-14);
  // And it goes the same way over the ground.
  const auto C = [](const Vector3d& angles) {
    return strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(angles));
  };
  REQUIRE((C(euler_turned) * v_turned - C(euler) * v_b).norm() < 1e-14);
}

}  // namespace frames_test
