// SPDX-License-Identifier: Apache-2.0
// Plugin odometry: the arc against fine steps, Φ against differences, noise against drawn samples, and every sign.
#include "../../plugins/odometry/planar_odometry.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "../../plugins/odometry/heading_block.hpp"
#include "../../plugins/odometry/planar_arc.hpp"
#include "bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "random/normal.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace odometry_test {

using namespace binnacle;
using namespace binnacle::odometry;
using namespace binnacle::test;
using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

const Vector3d berlin(0.9165, 0.2334, 80);
const AdditiveKind ecef_position("position.ecef", 3, "m"), scale(1, "1"), rate_bias(1, "rad/s");
const PositionKind geodetic;
const json quiet{{"speed_noise", 0.0}, {"yaw_rate_noise", 0.0}, {"height_noise", 0.0}};
const json noisy{{"speed_noise", 0.2},     {"yaw_rate_noise", 0.01}, {"height_noise", 0.1},
                 {"distance_noise", 0.05}, {"side_noise", 0.02},     {"turn_noise", 0.03}};

const StateBlock& heading_kind() {
  static const auto block = bind<HeadingBlock>();
  return *block;
}

using Names = std::vector<std::string>;  // fields that a channel lacks
const Names no_wheels = {"left_speed", "right_speed"}, no_body = {"speed", "yaw_rate"};

/// A step of as many samples as speeds are given, all of one length.
struct Drive {
  enum Of { body, wheels };  // speed and yaw rate, or the left and the right wheel
  std::vector<double> numbers;
  std::vector<InputSample> samples;
  Step step;
  Drive(const std::vector<Vector2d>& pairs, double dt, Of of = body) {
    for (const Vector2d& each : pairs) {
      numbers.insert(numbers.end(), {NAN, NAN, NAN, NAN});
      (numbers.end() - 4 + 2 * of)[0] = each[0], (numbers.end() - 4 + 2 * of)[1] = each[1];
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      InputSample sample;
      sample.t0 = nanoseconds(dt * static_cast<double>(i)), sample.t1 = nanoseconds(dt * static_cast<double>(i + 1));
      sample.whole_t0 = sample.t0, sample.whole_t1 = sample.t1;
      sample.dt = dt;
      sample.fields = numbers.data() + 4 * i;
      samples.push_back(sample);
    }
    step = {0, samples.back().t1, dt * static_cast<double>(samples.size()), samples};
  }
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;
};

struct Vehicle {
  bool is_ecef = false;
  double yaw = 1.1, scale_error = 0.03, bias = 0.004;
  PortStates ports() const {
    const Vector3d r = strapdown::ecef_from_lla(berlin);
    const PortState place = is_ecef ? PortState{&ecef_position, {r[0], r[1], r[2]}, 10, 1e-8}
                                    // ECEF coordinates come in steps of 1e-9 m; differences have several

                                    : PortState{&geodetic, {berlin[0], berlin[1], berlin[2]}, 10, 1e-8};
    const PortState open;
    return {is_ecef ? place : open,
            is_ecef ? open : place,
            {&heading_kind(), {yaw}, 0.1},
            {&scale, {scale_error}, 0.01},
            {&rate_bias, {bias}, 0.01}};
  }
  std::unique_ptr<PlanarOdometry> model(json parameters, const Names& lacks = no_wheels) const {
    Ports bound{{"heading", &heading_kind()}, {"scale", &scale}, {"yaw_rate_bias", &rate_bias}};
    if (is_ecef) {
      bound["ecef_position"] = &ecef_position;
    } else {
      bound["position"] = &geodetic;
    }
    return bind<PlanarOdometry>({std::move(parameters), bound, lacks});
  }
  /// North, east, down of where a step leads, and the heading there.
  Eigen::Vector4d way(const json& parameters, const Drive& drive, const Names& lacks = no_wheels) const {
    const auto bound = model(parameters, lacks);
    Complaints out;
    const auto made = ProcessCheck(*bound, PlanarOdometry::spec()).propagate(ports(), drive.step, {}, out);
    INFO(out.text());
    REQUIRE(out.empty());
    const Vector3d to = vector_at<3>(made.x_plus[is_ecef ? 0 : 1].data());
    const Vector3d d =
        is_ecef ? Vector3d(strapdown::C_en(berlin[0], berlin[1]).transpose() * (to - strapdown::ecef_from_lla(berlin)))
                : strapdown::position_minus(to, berlin);
    return {d[0], d[1], d[2], made.x_plus[2][0]};
  }
};

}  // namespace

TEST_CASE("heading: the Jacobian of its output", "[odometry]") {
  REQUIRE_NO_COMPLAINTS(check_outputs(heading_kind(), {3.1}, 1e-3, 1e-9));
}

TEST_CASE("odometry: a vehicle goes where it heads, and turns the way its sensor gives") {
  Vehicle car;
  car.scale_error = car.bias = 0;
  json still = quiet;
  still["earth_rate"] = false;
  const Drive straight({{10, 0}}, 0.5);
  for (const bool is_ecef : {false, true}) {
    car.is_ecef = is_ecef;
    car.yaw = M_PI / 2;
    const auto east = car.way(still, straight);
    CHECK(std::abs(east[1] - 5) < 1e-5);
    CHECK(std::abs(east[0]) < 1e-5);
    car.yaw = 0;
    CHECK(std::abs(car.way(still, straight)[0] - 5) < 1e-5);
    // Clockwise, seen from above: from north towards east.
    const Drive turning({{10, 0.4}}, 0.5);
    const auto right = car.way(still, turning);
    CHECK(right[1] > 0.1);
    CHECK(std::abs(right[3] - 0.2) < 1e-5);
    json other = still;
    other["positive_turn"] = "anticlockwise";
    CHECK(car.way(other, turning)[1] < -0.1);
    // A sensor that gives too much: the way is shorter, the turn less.
    car.scale_error = 0.25, car.bias = 0.4;
    const auto corrected = car.way(still, turning);
    CHECK(std::abs(corrected[0] - 4) < 1e-5);
    CHECK(std::abs(corrected[3]) < 1e-5);
    car.scale_error = car.bias = 0;
  }
  // The earth turns anticlockwise, seen from above the north pole, so that a gyroscope at rest gives a negative rate of
  // yaw: −Ω sin L; and the vehicle does not turn.
  const double earth = strapdown::wgs84::omega_ie * std::sin(berlin[0]);
  const Drive standing({{0, -earth}}, 100);
  car.yaw = 0.3;
  CHECK(std::abs(car.way(quiet, standing)[3] - 0.3) < 1e-12);
}

TEST_CASE("odometry: two wheels") {
  Vehicle robot;
  robot.yaw = robot.scale_error = robot.bias = 0;
  json parameters = quiet;
  parameters["track"] = 0.5;
  // About the point between them: the left one forward turns it to the right. No earth's rate: wheels turn with the ground.
  const Eigen::Vector4d between = robot.way(parameters, Drive({{0.1, -0.1}}, 1, Drive::wheels), no_body);
  CHECK(between[3] == Approx(0.4));
  CHECK(between.head<3>().norm() < 1e-8);
  // About the right one.
  const Eigen::Vector4d about = robot.way(parameters, Drive({{M_PI / 4, 0}}, 1, Drive::wheels), no_body);
  CHECK(about[3] == Approx(M_PI / 2).margin(1e-7));
  CHECK(about[0] == Approx(0.25).margin(1e-6));
  CHECK(about[1] == Approx(0.25).margin(1e-6));
  const Vehicle driving;
  const Drive drive({{3, 2.8}}, 0.2, Drive::wheels);
  const auto model = driving.model(parameters, no_body);
  REQUIRE_NO_COMPLAINTS(
      ProcessCheck(*model, PlanarOdometry::spec()).transition(driving.ports(), drive.step, {}, {1e-6, 1e-9}));
}

TEST_CASE("odometry: one pair of speeds, and the track of two wheels") {
  const auto message = [](const json& parameters, const Names& lacks) -> std::string {
    try {
      Vehicle().model(parameters, lacks);
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return "";
  };
  json with_track = quiet;
  with_track["track"] = 1;
  CHECK(message(quiet, no_wheels).empty());
  CHECK(message(quiet, {}).empty());
  CHECK(message(quiet, {"yaw_rate"}).find("/fields: the input carries no field for 'yaw_rate'") == 0);
  CHECK(message(quiet, no_body).find("/fields: the input carries no field for 'speed'") == 0);
  CHECK(message(with_track, no_body).empty());
  CHECK(message(with_track, no_wheels).find("/fields: the input carries no field for 'left_speed'") == 0);
  CHECK(message(with_track, {"right_speed"}).find("/fields: the input carries no field for 'right_speed'") == 0);
}

TEST_CASE("odometry: the arc is where ten thousand short steps lead") {
  for (const double rate : {0.0, 1e-7, 0.003, -0.9, 4.0}) {
    const double dt = 0.7, v = 12, yaw = 2.5;
    Vector2d way = Vector2d::Zero();
    const int steps = 10000;
    for (int i = 0; i < steps; ++i) {
      const double at = yaw + rate * dt * (i + 0.5) / steps;
      way += v * dt / steps * Vector2d(std::cos(at), std::sin(at));
    }
    CHECK((PlanarArc(yaw, v, rate, dt).way - way).norm() < 1e-6);
  }
}

TEST_CASE("odometry: heading north changes as one goes east") {
  // A great circle: from Berlin due east by geodesy of the sphere, ψ grows by sin L times the change of longitude.
  Vehicle car;
  car.scale_error = car.bias = 0, car.yaw = M_PI / 2;
  json still = quiet;
  still["earth_rate"] = false;
  const auto made = car.way(still, Drive({{1000, 0}}, 1));
  const double dlon = 1000 / ((strapdown::radii(berlin[0]).transverse + berlin[2]) * std::cos(berlin[0]));
  CHECK(std::abs(made[3] - M_PI / 2 - dlon * std::sin(berlin[0])) < 1e-9);
}

TEST_CASE("odometry: transition against differences, in either kind of position") {
  for (const bool is_ecef : {false, true})
    for (const bool feels_earth : {false, true}) {
      Vehicle car;
      car.is_ecef = is_ecef;
      json parameters = noisy;
      parameters["earth_rate"] = feels_earth;
      const auto model = car.model(parameters);
      const ProcessCheck check(*model, PlanarOdometry::spec());
      const Drive one({{14, 0.5}}, 0.4), three({{14, 0.5}, {12, -0.2}, {-3, 0.1}}, 0.3), rest({{14, 0.5}}, 0);
      INFO((is_ecef ? "ecef" : "geodetic"));
      REQUIRE_NO_COMPLAINTS(check.transition(car.ports(), one.step, {}, {1e-7}));
      REQUIRE_NO_COMPLAINTS(check.transition(car.ports(), three.step, {}, {1e-7}));
      REQUIRE_NO_COMPLAINTS(check.zero_step(car.ports(), rest.step, {}));
    }
}

TEST_CASE("odometry: geodetic and ECEF lead to the same place, heading and noise") {
  Vehicle one, other;
  other.is_ecef = true;
  const Drive drive({{14, 0.5}, {12, -0.2}}, 0.4);
  const auto a = one.way(quiet, drive), b = other.way(quiet, drive);
  // A way along parallels and meridians is not a straight one: the difference grows as its square.
  const double chart = a.head<2>().squaredNorm() * std::tan(berlin[0]) / 6.37e6;
  CHECK((a.head<3>() - b.head<3>()).norm() < chart);
  CHECK(std::abs(a[3] - b[3]) < 1e-9);
  Complaints out;
  const auto in_ned =
      ProcessCheck(*one.model(noisy), PlanarOdometry::spec()).propagate(one.ports(), drive.step, {}, out);
  const auto in_ecef =
      ProcessCheck(*other.model(noisy), PlanarOdometry::spec()).propagate(other.ports(), drive.step, {}, out);
  // A geodetic error is in the axes of where it ends.
  const Vector3d end = vector_at<3>(in_ned.x_plus[1].data());
  const Eigen::Matrix3d C_ne = strapdown::C_en(end[0], end[1]).transpose();
  CHECK((C_ne * in_ecef.noise.at({0, 0}) * C_ne.transpose() - in_ned.noise.at({1, 1})).norm() < 1e-6);
  CHECK((C_ne * in_ecef.noise.at({0, 2}) - in_ned.noise.at({1, 2})).norm() < 1e-6);
  CHECK((C_ne * in_ecef.transition.at({0, 3}) - in_ned.transition.at({1, 3})).norm() < chart);
}

TEST_CASE("odometry: noise of a step is that of drawn drives") {
  // White speed, slip and yaw rate in a hundred pieces of a step, integrated step by step.
  const double dt = 0.5, v = 9, rate = 0.15, yaw = 0.7;
  const PlanarNoise noise{0.04, 0.01, 1e-3};
  const int runs = 20000, pieces = 100;
  auto stream = random::stream(7, "odometry");
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  const PlanarArc arc(yaw, v, rate, dt);
  for (int run = 0; run < runs; ++run) {
    const double h = dt / pieces, root = std::sqrt(h);
    Vector2d at = Vector2d::Zero();
    double heading = yaw;
    for (int i = 0; i < pieces; ++i) {
      const double turn = rate * h + std::sqrt(noise.yaw) * root * random::normal(stream);
      const double along = v * h + std::sqrt(noise.speed) * root * random::normal(stream);
      const double across = std::sqrt(noise.side) * root * random::normal(stream);
      const Vector2d f(std::cos(heading + turn / 2), std::sin(heading + turn / 2));
      at += along * f + across * Vector2d(-f[1], f[0]);
      heading += turn;
    }
    Eigen::Vector3d error;
    error << at - arc.way, heading - yaw - rate * dt;
    sum += error * error.transpose() / runs;
  }
  const Eigen::Matrix3d Q = arc_noise(arc, noise, v, dt);
  // In units of σ: sampling leaves √(2/20000) = 1 %, the direction of the chord θ/2 = 4 % of what lies between the axes.
  const Eigen::Vector3d s = Q.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d difference = s.asDiagonal() * (sum - Q) * s.asDiagonal();
  INFO(difference);
  CHECK(difference.cwiseAbs().maxCoeff() < 0.05);
  CHECK(std::abs(Q(0, 2)) > 0.2 * std::sqrt(Q(0, 0) * Q(2, 2)));  // a wrong sign of it would be seen above
}

TEST_CASE("odometry: noise by way and by angle stands still with the vehicle, and a bridged hole has more") {
  Vehicle car;
  const auto model = car.model(noisy);
  const ProcessCheck check(*model, PlanarOdometry::spec());
  Complaints out;
  Drive standing({{0, 0.004}}, 1), driving({{10, 0.004}}, 1);
  const auto rest = check.propagate(car.ports(), standing.step, {}, out).noise;
  CHECK(rest.at({1, 1})(2, 2) == 0);
  CHECK(std::abs(rest.at({1, 1})(0, 0) + rest.at({1, 1})(1, 1) - 0.04) < 1e-9);
  const double v = 10 / 1.03;
  const auto moving = check.propagate(car.ports(), driving.step, {}, out).noise;
  CHECK(std::abs(moving.at({1, 1})(2, 2) - 0.01 * v) < 1e-9);
  const double planar = 0.04 + 0.0025 * v + 0.0004 * v + moving.at({2, 2})(0, 0) * v * v / 3;
  CHECK(std::abs(moving.at({1, 1})(0, 0) + moving.at({1, 1})(1, 1) - planar) < 1e-9);
  driving.samples[0].bridges = true;
  driving.step.samples = driving.samples;
  driving.step.bridges = true;
  const auto bridged = check.propagate(car.ports(), driving.step, {}, out).noise;
  const double bridge_rate = 5 * M_PI / 180;
  CHECK(std::abs(bridged.at({2, 2})(0, 0) - moving.at({2, 2})(0, 0) - bridge_rate * bridge_rate) < 1e-12);
  CHECK(bridged.at({1, 1}).trace() > moving.at({1, 1}).trace() + 1);
}

TEST_CASE("odometry: the heading wraps, and what it can not be is refused") {
  REQUIRE_NO_COMPLAINTS(check_block(heading_kind(), {0.4}, 1, 1e-15));
  double x = 3.1, delta = 0.2, y = 0, back = 0;
  heading_kind().plus({&x, 1}, {&delta, 1}, {&y, 1});
  CHECK(std::abs(y - (3.3 - 2 * M_PI)) < 1e-15);
  heading_kind().minus({&y, 1}, {&x, 1}, {&back, 1});
  CHECK(std::abs(back - 0.2) < 1e-14);
  for (const double wrong : {std::nan(""), 7.0, -400.0}) CHECK_FALSE(heading_kind().write({&wrong, 1}, {&x, 1}));
  CHECK_THROWS_AS(bind<PlanarOdometry>({quiet, {{"heading", &heading_kind()}}, no_wheels}), ComponentError);
  CHECK_THROWS_AS(bind<PlanarOdometry>(
                      {quiet,
                       {{"heading", &heading_kind()}, {"position", &geodetic}, {"ecef_position", &ecef_position}},
                       no_wheels}),
                  ComponentError);
}

// 400 runs of 30 s with turns, from a heading, a scale and a bias that are drawn. NEES of all five has 5 dof: 99 % of pairs of
// such means lie within 5 ± 2.81 √(10/400).
TEST_CASE("odometry: errors are as large as it says") {
  for (const bool is_ecef : {false, true}) {
    Vehicle start;
    start.is_ecef = is_ecef;
    const auto model = start.model({{"speed_noise", 0.2}, {"yaw_rate_noise", 0.005}, {"height_noise", 0.0}});
    const ProcessCheck check(*model, PlanarOdometry::spec());
    const std::size_t place = is_ecef ? 0 : 1;
    const int at = static_cast<int>(place);
    auto stream = random::stream(5, is_ecef ? "ecef" : "geodetic");
    constexpr double dt = 0.25, s_yaw = 0.02, s_scale = 0.01, s_bias = 0.001;
    constexpr int runs = 400, steps = 120;
    double nees = 0;
    for (int run = 0; run < runs; ++run) {
      Vehicle drawn = start;
      drawn.yaw += s_yaw * random::normal(stream);
      drawn.scale_error += s_scale * random::normal(stream);
      drawn.bias += s_bias * random::normal(stream);
      PortStates truth = drawn.ports(), estimate = start.ports();
      Complaints out;
      Eigen::Matrix<double, 6, 6> P = Eigen::Matrix<double, 6, 6>::Zero();  // position, heading, scale, bias
      P.diagonal().tail<3>() << s_yaw * s_yaw, s_scale * s_scale, s_bias * s_bias;
      for (int k = 0; k < steps; ++k) {
        const double v = 8 + 3 * std::sin(0.05 * k), w = 0.2 * std::cos(0.125 * k);
        const Drive real({{v, w}}, dt),
            seen({{v + 0.2 * (1 + drawn.scale_error) / std::sqrt(dt) * random::normal(stream),
                   w + 0.005 / std::sqrt(dt) * random::normal(stream)}},
                 dt);
        const auto moved = check.propagate(truth, real.step, {}, out),
                   made = check.propagate(estimate, seen.step, {}, out);
        Eigen::Matrix<double, 6, 6> Phi = Eigen::Matrix<double, 6, 6>::Identity(), Q = Phi * 0;
        Phi.topRows<4>() << made.transition.at({at, at}), made.transition.at({at, 2}), made.transition.at({at, 3}),
            made.transition.at({at, 4}), made.transition.at({2, at}), made.transition.at({2, 2}),
            made.transition.at({2, 3}), made.transition.at({2, 4});
        Q.topLeftCorner<4, 4>() << made.noise.at({at, at}), made.noise.at({at, 2}), made.noise.at({at, 2}).transpose(),
            made.noise.at({2, 2});
        P = Phi * P * Phi.transpose() + Q;
        for (const std::size_t port : {place, std::size_t{2}})
          truth[port].x = moved.x_plus[port], estimate[port].x = made.x_plus[port];
      }
      REQUIRE(out.empty());
      const StateBlock& kind = *estimate[place].block;
      Eigen::Matrix<double, 6, 1> error;
      kind.minus({truth[place].x.data(), 3}, {estimate[place].x.data(), 3}, {error.data(), 3});
      error.tail<3>() << std::remainder(truth[2].x[0] - estimate[2].x[0], 2 * M_PI),
          drawn.scale_error - start.scale_error, drawn.bias - start.bias;
      if (is_ecef) {
        Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Identity();
        turn.topLeftCorner<3, 3>() = strapdown::C_en(berlin[0], berlin[1]).transpose();
        error = turn * error, P = turn * P * turn.transpose();
      }
      const Eigen::Array<int, 5, 1> rows(0, 1, 3, 4, 5);  // the height is known
      const Eigen::Matrix<double, 5, 5> part = P(rows, rows);
      const Eigen::Matrix<double, 5, 1> of = error(rows);
      nees += of.dot(part.llt().solve(of)) / runs;
    }
    INFO(is_ecef << " " << nees);
    CHECK(std::abs(nees - 5) < 2.81 * std::sqrt(10.0 / runs));
  }
}

TEST_CASE("odometry: what makes nothing of the speed is refused") {
  Vehicle car;
  car.scale_error = -0.95;
  const auto model = car.model(quiet);
  const Drive drive({{1, 0}}, 1), wild({{1e300, 0}}, 1);
  Complaints out;
  ProcessCheck(*model, PlanarOdometry::spec()).propagate(car.ports(), drive.step, {}, out);
  CHECK(out.text().find("refused") != std::string::npos);
  car.scale_error = 0;
  Complaints other;
  ProcessCheck(*model, PlanarOdometry::spec()).propagate(car.ports(), wild.step, {}, other);
  CHECK(other.text().find("beyond that of any vehicle") != std::string::npos);
}

}  // namespace odometry_test
