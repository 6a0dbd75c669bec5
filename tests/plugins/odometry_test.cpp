// SPDX-License-Identifier: Apache-2.0
// Planar odometry: its way against the closed form, its signs, Φ by differences, and its noise by Monte Carlo.
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "../../plugins/odometry/heading_block.hpp"
#include "../../plugins/odometry/planar_odometry.hpp"
#include "bind.hpp"
#include "catch.hpp"
#include "kind_blocks.hpp"
#include "model_check.hpp"
#include "strapdown/earth.hpp"

using namespace binnacle;
using namespace binnacle::odometry;
using namespace binnacle::test;
using Eigen::Vector3d;

namespace {

const Vector3d berlin(0.9165, 0.2334, 80);
const PositionKind geodetic;
const AdditiveKind ecef("position.ecef", 3, "m"), heading("heading", 1, "rad"), scale(1, "1"), rate_bias(1, "rad/s");
const nlohmann::json quiet = {{"speed_noise", 0.1},     {"yaw_rate_noise", 0.002}, {"height_noise", 0.05},
                              {"distance_noise", 0.03}, {"side_noise", 0.02},      {"turn_noise", 0.01}};

nlohmann::json with(nlohmann::json json, const nlohmann::json& more) {
  json.update(more);
  return json;
}

const std::vector<std::string> of_body = {"left_speed", "right_speed"}, of_wheels = {"speed", "yaw_rate"};

/// One sample of speed and yaw rate, or of two wheels, that fills a step.
struct Sample {
  struct Wheels {
    double left, right;
  };
  Sample(double speed, double yaw_rate, double dt, bool bridges = false)
      : Sample({speed, yaw_rate, NAN, NAN}, dt, bridges) {}
  Sample(Wheels wheels, double dt) : Sample({NAN, NAN, wheels.left, wheels.right}, dt, false) {}
  Sample(const std::array<double, 4>& all, double dt, bool bridges) : fields(all) {
    const Time t = nanoseconds(dt);
    input = {0, t, dt, 0, t, fields.data(), bridges};
    step = {0, t, dt, {&input, 1}, bridges};
  }
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;
  std::array<double, 4> fields;
  InputSample input;
  Step step;
};

struct Bench {
  explicit Bench(nlohmann::json parameters, bool in_ecef = false, const std::vector<std::string>& lacks = of_body)
      : is_ecef(in_ecef),
        model(bind<PlanarOdometry>({std::move(parameters),
                                    is_ecef ? Ports{{"ecef_position", &ecef},
                                                    {"heading", &heading},
                                                    {"scale", &scale},
                                                    {"yaw_rate_bias", &rate_bias}}
                                            : Ports{{"position", &geodetic},
                                                    {"heading", &heading},
                                                    {"scale", &scale},
                                                    {"yaw_rate_bias", &rate_bias}},
                                    lacks})),
        check(*model, PlanarOdometry::spec()) {}

  PortStates ports(double yaw, double s = 0, double b = 0, const Vector3d& lla = berlin) const {
    const Vector3d r = strapdown::ecef_from_lla(lla);
    const PortState place{&geodetic, {lla[0], lla[1], lla[2]}, 10, 1e-8}, of_ecef{&ecef, {r[0], r[1], r[2]}, 10, 1e-8};
    return {is_ecef ? of_ecef : PortState{},
            is_ecef ? PortState{} : place,
            {&heading, {yaw}, 1e-2},
            {&scale, {s}, 1e-2},
            {&rate_bias, {b}, 1e-3}};
  }
  /// north, east, down [m] and yaw after a step, from `berlin`.
  Eigen::Vector4d after(const PortStates& from, const Sample& sample) const {
    Complaints out;
    const Propagation made = check.propagate(from, sample.step, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    const auto& x = made.x_plus[is_ecef ? 0 : 1];
    const Vector3d r = is_ecef ? Vector3d(x[0], x[1], x[2]) : strapdown::ecef_from_lla(Vector3d(x[0], x[1], x[2]));
    Eigen::Vector4d moved;
    moved << strapdown::C_en(berlin[0], berlin[1]).transpose() * (r - strapdown::ecef_from_lla(berlin)),
        made.x_plus[2][0];
    return moved;
  }
  bool is_ecef;
  std::shared_ptr<const PlanarOdometry> model;
  ProcessCheck check;
};

}  // namespace

TEST_CASE("odometry: a straight way and a quarter of a turn are where geometry says") {
  for (const bool is_ecef : {false, true}) {
    const Bench bench(with(quiet, {{"earth_rate", false}}), is_ecef);
    const auto straight = bench.after(bench.ports(M_PI / 6), Sample(10, 0, 2));
    CHECK(std::abs(straight[0] - 20 * std::cos(M_PI / 6)) < 1e-3);  // the earth curves by 20²/2R
    CHECK(std::abs(straight[1] - 20 * std::sin(M_PI / 6)) < 1e-3);
    CHECK(std::abs(straight[2]) < 1e-3);
    // Clockwise from north by a quarter with radius 5 m: 5 m north, 5 m east, heading east.
    const double dt = 2, rate = M_PI / 2 / dt, speed = 5 * rate;
    const auto turn = bench.after(bench.ports(0), Sample(speed, rate, dt));
    CHECK(std::abs(turn[0] - 5) < 1e-4);
    CHECK(std::abs(turn[1] - 5) < 1e-4);
    CHECK(std::abs(turn[3] - M_PI / 2) < 1e-5);  // meridians meet: 5 m tan(L)/R
    const auto back = bench.after(bench.ports(0), Sample(-speed, rate, dt));
    CHECK(std::abs(back[0] + 5) < 1e-4);
    CHECK(std::abs(back[1] + 5) < 1e-4);
  }
}

TEST_CASE("odometry: signs of the turn, the bias, the scale and the earth's rate") {
  const Bench plain(with(quiet, {{"earth_rate", false}})),
      left(with(quiet, {{"earth_rate", false}, {"positive_turn", "anticlockwise"}})), gyro(quiet);
  CHECK(plain.after(plain.ports(0), Sample(0, 0.1, 1))[3] == Approx(0.1));
  CHECK(left.after(left.ports(0), Sample(0, 0.1, 1))[3] == Approx(-0.1));
  CHECK(plain.after(plain.ports(0, 0, 0.02), Sample(0, 0.1, 1))[3] == Approx(0.08));
  CHECK(left.after(left.ports(0, 0, 0.02), Sample(0, 0.1, 1))[3] == Approx(-0.12));
  CHECK(plain.after(plain.ports(0, 0.25), Sample(10, 0, 1))[0] == Approx(8).margin(1e-4));
  // A gyroscope at rest about the vertical feels −Ω sin L about down.
  const double rest = -7.292115e-5 * std::sin(berlin[0]);
  CHECK(std::abs(gyro.after(gyro.ports(1), Sample(0, rest, 100))[3] - 1) < 1e-9);
  const Bench turned(with(quiet, {{"earth_rate", false}}));
  CHECK(std::abs(turned.after(turned.ports(3.1), Sample(0, 0.1, 1))[3] - (3.2 - 2 * M_PI)) < 1e-12);
}

TEST_CASE("odometry: two wheels") {
  const Bench bench(with(quiet, {{"track", 0.5}}), false, of_wheels);
  // About the point between them: the left one forward turns it to the right. No earth's rate: wheels turn with the ground.
  const auto right = bench.after(bench.ports(0), Sample(Sample::Wheels{0.1, -0.1}, 1));
  CHECK(right[3] == Approx(0.4));
  CHECK(right.head<3>().norm() < 1e-8);
  // About the right one.
  const auto about = bench.after(bench.ports(0), Sample(Sample::Wheels{M_PI / 4, 0}, 1));
  CHECK(about[3] == Approx(M_PI / 2).margin(1e-7));
  CHECK(about[0] == Approx(0.25).margin(1e-6));
  CHECK(about[1] == Approx(0.25).margin(1e-6));
  const Sample sample(Sample::Wheels{3, 2.8}, 0.2);
  REQUIRE_NO_COMPLAINTS(bench.check.transition(bench.ports(0.7, 0.02, 0.01), sample.step, {}, {1e-6, 1e-9}));

  const auto message = [](const nlohmann::json& parameters, const std::vector<std::string>& lacks) -> std::string {
    try {
      Bench(parameters, false, lacks);
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return "";
  };
  CHECK(message(quiet, of_body).empty());
  CHECK(message(quiet, {}).empty());
  CHECK(message(quiet, {"yaw_rate"}).find("/fields: the input carries no field for 'yaw_rate'") == 0);
  CHECK(message(quiet, of_wheels).find("/fields: the input carries no field for 'speed'") == 0);
  const nlohmann::json by_wheels = with(quiet, {{"track", 1}});
  CHECK(message(by_wheels, of_wheels).empty());
  CHECK(message(by_wheels, of_body).find("/fields: the input carries no field for 'left_speed'") == 0);
  CHECK(message(by_wheels, {"right_speed"}).find("/fields: the input carries no field for 'right_speed'") == 0);
}

TEST_CASE("odometry: transition by differences, noise of a step is that of its parts") {
  for (const bool is_ecef : {false, true})
    for (const bool feels_earth : {false, true}) {
      INFO(is_ecef << " " << feels_earth);
      const Bench bench(with(quiet, {{"earth_rate", feels_earth}}), is_ecef);
      const Sample sample(12, 0.3, 0.2);
      const auto ports = bench.ports(0.7, 0.02, 0.01);
      REQUIRE_NO_COMPLAINTS(bench.check.transition(ports, sample.step, {}, {1e-6, 1e-9}));
      Complaints out;
      const auto made = bench.check.propagate(ports, sample.step, {}, out);
      const auto key = std::pair(is_ecef ? 0 : 1, is_ecef ? 0 : 1);
      const Eigen::MatrixXd& Q = made.noise.at(key);
      CHECK((Q - Q.transpose()).norm() <= 1e-15 * Q.norm());
      CHECK(Q.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() > 0);
      const double v = 12 / 1.02;
      CHECK(made.noise.at({2, 2})(0, 0) ==
            Approx(0.2 *
                   (0.002 * 0.002 + 0.0001 * std::abs(0.29 + (feels_earth ? 7.292115e-5 * std::sin(berlin[0]) : 0)))));
      CHECK(Q.trace() ==
            Approx(0.2 * (0.01 + v * (0.0009 + 0.0004 + 0.0025)) + made.noise.at({2, 2})(0, 0) * v * v * 0.04 / 3));
    }
}

TEST_CASE("odometry: a bridge of a hole has the noise that its parameters say") {
  const Bench bench(with(quiet, {{"bridge", {{"acceleration", 2.0}, {"rate", 0.1}}}}));
  Complaints out;
  const double plain = bench.check.propagate(bench.ports(0), Sample(10, 0, 1).step, {}, out).noise.at({2, 2})(0, 0);
  const double bridged =
      bench.check.propagate(bench.ports(0), Sample(10, 0, 1, true).step, {}, out).noise.at({2, 2})(0, 0);
  CHECK(bridged - plain == Approx(0.01));
}

// 200 runs of 15 s with turns; the NEES of position and heading has 3 dof: 99 % of such means lie within 3 ± 2.58 √(6/200).
TEST_CASE("odometry: errors are as large as it says") {
  const Bench bench({{"speed_noise", 0.2}, {"yaw_rate_noise", 0.005}, {"height_noise", 0.0}, {"earth_rate", false}});
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr double dt = 0.1;
  constexpr int runs = 200, steps = 150;
  double nees = 0;
  for (int run = 0; run < runs; ++run) {
    auto truth = bench.ports(0.4), estimate = truth;
    Eigen::Matrix4d P = Eigen::Matrix4d::Zero();  // position, heading
    for (int k = 0; k < steps; ++k) {
      const double v = 8 + 3 * std::sin(0.02 * k), w = 0.2 * std::cos(0.05 * k);
      Complaints out;
      const auto real = bench.check.propagate(truth, Sample(v, w, dt).step, {}, out);
      const Sample seen(v + 0.2 / std::sqrt(dt) * normal(random), w + 0.005 / std::sqrt(dt) * normal(random), dt);
      const auto made = bench.check.propagate(estimate, seen.step, {}, out);
      Eigen::Matrix4d Phi, Q;
      Phi << made.transition.at({1, 1}), made.transition.at({1, 2}), made.transition.at({2, 1}),
          made.transition.at({2, 2});
      Q << made.noise.at({1, 1}), made.noise.at({1, 2}), made.noise.at({1, 2}).transpose(), made.noise.at({2, 2});
      P = Phi * P * Phi.transpose() + Q;
      for (const int port : {1, 2})
        truth[static_cast<std::size_t>(port)].x = real.x_plus[static_cast<std::size_t>(port)],
        estimate[static_cast<std::size_t>(port)].x = made.x_plus[static_cast<std::size_t>(port)];
    }
    Eigen::Vector3d place, error;
    geodetic.minus({truth[1].x.data(), 3}, {estimate[1].x.data(), 3}, {place.data(), 3});
    error << place[0], place[1], std::remainder(truth[2].x[0] - estimate[2].x[0], 2 * M_PI);
    const Eigen::Array3i rows(0, 1, 3);
    Eigen::Matrix3d part;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) part(i, j) = P(rows[i], rows[j]);
    nees += error.dot(part.llt().solve(error)) / runs;
  }
  INFO(nees);
  CHECK(std::abs(nees - 3) < 2.58 * std::sqrt(6.0 / runs));
}

TEST_CASE("odometry: a heading wraps") {
  const auto block = bind<HeadingBlock>();
  double x = 3.0, y = 0, delta = 0.5;
  block->plus({&x, 1}, {&delta, 1}, {&y, 1});
  CHECK(y == Approx(3.5 - 2 * M_PI));
  double back = 0;
  block->minus({&y, 1}, {&x, 1}, {&back, 1});
  CHECK(back == Approx(0.5));
}

TEST_CASE("odometry: one position, geodetic or ECEF, and a scale that makes nothing of the speed is refused") {
  CHECK_THROWS_AS(bind<PlanarOdometry>({quiet, {{"heading", &heading}}, {}}), ComponentError);
  CHECK_THROWS_AS(bind<PlanarOdometry>(
                      {quiet, {{"heading", &heading}, {"position", &geodetic}, {"ecef_position", &ecef}}, {}}),
                  ComponentError);
  const Bench bench(quiet);
  Complaints out;
  bench.check.propagate(bench.ports(0, -0.95), Sample(1, 0, 1).step, {}, out);
  CHECK(out.text().find("refused") != std::string::npos);
}
