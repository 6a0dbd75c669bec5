// SPDX-License-Identifier: Apache-2.0
// Plugin navigation: the blocks' laws.
#include <cmath>

#include "../../plugins/navigation/attitude_block.hpp"
#include "../../plugins/navigation/position_block.hpp"
#include "../../plugins/navigation/velocity_block.hpp"

#include "inertial_bench.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace navigation_test {

using namespace binnacle;
using namespace binnacle::navigation;
using namespace binnacle::test;
using Eigen::Vector3d;

TEST_CASE("blocks: kinds, and the laws from nothing to near the edge", "[navigation]") {
  const auto position = bind<PositionBlock>();
  const auto velocity = bind<VelocityBlock>();
  const auto attitude = bind<AttitudeBlock>();
  REQUIRE(position->declaration().kind == "position");
  REQUIRE(velocity->declaration().kind == "velocity.ned");
  REQUIRE(attitude->declaration().kind == "attitude");
  REQUIRE(attitude->declaration().norms[0].name == "tilt");
  REQUIRE(attitude->declaration().error_display_unit == "deg");
  const PositionKind plain_position;
  const AttitudeKind plain_attitude;
  for (const Flight& flight : flights) {
    INFO(flight.name);
    const auto lla = numbers(flight.lla);
    const auto q = numbers(strapdown::quaternion_from_euler(flight.roll_pitch_yaw));
    REQUIRE_NO_COMPLAINTS(check_block(*position, lla, 5e3, 1e-8));
    REQUIRE_NO_COMPLAINTS(check_block(*velocity, numbers(flight.v_n), 100.0, 1e-13));
    REQUIRE_NO_COMPLAINTS(check_block(*attitude, q, M_PI - 1e-3, 1e-14, 1e-13));
    // The same maps as those written from the definition of the kinds.
    const double metres[3] = {1200, -800, 30}, phi[3] = {0.4, -1.1, 0.8};
    double there[3], plainly_there[3], turned[4], plainly_turned[4];
    position->plus(lla, metres, there), plain_position.plus(lla, metres, plainly_there);
    Vector3d apart;
    plain_position.minus(there, plainly_there, apart);
    REQUIRE(apart.norm() < 2e-8);
    attitude->plus(q, phi, turned), plain_attitude.plus(q, phi, plainly_turned);
    plain_attitude.minus(turned, plainly_turned, apart);
    REQUIRE(apart.norm() < 1e-15);
  }
  REQUIRE_NO_COMPLAINTS(check_block(*attitude, {1, 0, 0, 0}, M_PI - 1e-6, 1e-14, 1e-13));
}

TEST_CASE("blocks: what write refuses, and what it wraps", "[navigation]") {
  const auto position = bind<PositionBlock>();
  const auto velocity = bind<VelocityBlock>();
  const auto attitude = bind<AttitudeBlock>();
  double x[4];
  const auto refuses = [&](const StateBlock& block, std::array<double, 3> outputs) {
    return block.write(outputs, {x, block.declaration().stored_size}).refusal == Refusal::invalid;
  };
  const double nan = std::nan("");
  REQUIRE(refuses(*position, {1.58, 0, 0}));
  REQUIRE(refuses(*position, {-1.58, 0, 0}));
  REQUIRE(refuses(*position, {0, 7, 0}));
  REQUIRE(refuses(*position, {0, 0, nan}));
  REQUIRE(refuses(*velocity, {0, nan, 0}));
  REQUIRE(refuses(*attitude, {0, 1.6, 0}));
  REQUIRE(refuses(*attitude, {nan, 0, 0}));
  REQUIRE(refuses(*attitude, {0, 0, 7}));
  REQUIRE_FALSE(refuses(*position, {0.5, 350 * degree, 0}));
  REQUIRE(std::abs(x[1] + 10 * degree) < 1e-15);
  REQUIRE_FALSE(refuses(*attitude, {0, 0, 350 * degree}));
  double angles[3];
  attitude->read(x, angles);
  REQUIRE(std::abs(angles[2] + 10 * degree) < 1e-15);
}

TEST_CASE("attitude: a mounted body is read in the axes in which it is mounted", "[navigation]") {
  const auto upright = bind<AttitudeBlock>({{{"mounting", {0, 90 * degree, 0}}}, {}, {}});
  const auto plain = bind<AttitudeBlock>();
  // Nose up, belly forward to the east: the ship's bow points east.
  const double level[3] = {0, 0, 90 * degree};
  double q[4];
  REQUIRE(upright->write(level, q));
  const Eigen::Matrix3d C = strapdown::dcm_from_quaternion(vector_at<4>(q));
  REQUIRE((C * Vector3d(1, 0, 0) - Vector3d(0, 0, -1)).norm() < 1e-15);
  REQUIRE((C * Vector3d(0, 0, 1) - Vector3d(0, 1, 0)).norm() < 1e-15);
  for (const Flight& flight : flights) {
    const auto x = numbers(strapdown::quaternion_from_euler(flight.roll_pitch_yaw));
    REQUIRE_NO_COMPLAINTS(check_block(*upright, x, 1.0, 1e-14, 1e-13));
    double angles[3], back[4];
    plain->read(x, angles);
    REQUIRE((vector_at<3>(angles) - flight.roll_pitch_yaw).norm() < 1e-14);
    REQUIRE(upright->write(angles, back));
    upright->read(back, angles);
    REQUIRE((vector_at<3>(angles) - flight.roll_pitch_yaw).norm() < 1e-14);
  }
}

TEST_CASE("attitude: an injected correction turns what remains by +half of it", "[navigation]") {
  const auto attitude = bind<AttitudeBlock>();
  const Vector3d delta{0.02, -0.03, 0.05};
  for (const Flight& flight : flights) {
    const auto q = numbers(strapdown::quaternion_from_euler(flight.roll_pitch_yaw));
    REQUIRE_NO_COMPLAINTS(check_reset(*attitude, q, delta, {1e-8}));
    REQUIRE_NO_COMPLAINTS(check_reset(*attitude, q, 20 * delta, {1e-8}));
  }
  Eigen::Matrix3d G;
  const auto q = numbers(strapdown::quaternion_from_euler(flights[0].roll_pitch_yaw));
  REQUIRE(attitude->reset_jacobian(q, delta, {G.data(), 3, 3, 3}));
  REQUIRE((G - Eigen::Matrix3d::Identity() - 0.5 * strapdown::skew(delta)).norm() < 1e-3);
  REQUIRE((G - Eigen::Matrix3d::Identity() + 0.5 * strapdown::skew(delta)).norm() > 3e-2);
}

TEST_CASE("attitude and position: the Jacobian of the outputs is that of what is read", "[navigation]") {
  const auto upright = bind<AttitudeBlock>({{{"mounting", {0, 90 * degree, 0}}}, {}, {}});
  const auto attitude = bind<AttitudeBlock>();
  const auto position = bind<PositionBlock>();
  for (const Flight& flight : flights) {
    const auto q = numbers(strapdown::quaternion_from_euler(flight.roll_pitch_yaw));
    REQUIRE_NO_COMPLAINTS(check_outputs(*attitude, q, 1e-5, 1e-7));
    REQUIRE_NO_COMPLAINTS(check_outputs(*upright, q, 1e-5, 1e-7));
    REQUIRE_NO_COMPLAINTS(check_outputs(*position, numbers(flight.lla), 1.0, 1e-8));
  }
}

TEST_CASE("attitude: near the vertical the outputs have no Jacobian", "[navigation]") {
  const auto attitude = bind<AttitudeBlock>();
  Eigen::Matrix3d J = Eigen::Matrix3d::Constant(7);
  const auto gives = [&](double from_vertical) {
    return attitude->output_jacobian(
        numbers(strapdown::quaternion_from_euler({0.3, std::numbers::pi / 2 - from_vertical, 1})), {J.data(), 3, 3, 3});
  };
  REQUIRE_FALSE(gives(0.9e-3));
  REQUIRE_FALSE(gives(0));
  REQUIRE(J == Eigen::Matrix3d::Constant(7));
  REQUIRE(gives(1.1e-3));
}

}  // namespace navigation_test
