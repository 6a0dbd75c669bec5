// SPDX-License-Identifier: Apache-2.0
// Plugin land: non-holonomic constraint, odometer, zero velocity, zero rate: Jacobians, signs of paper 001, refusals.
#include "../../plugins/frames/mounted_attitude.hpp"
#include "../../plugins/land/level.hpp"
#include "../../plugins/land/nhc.hpp"
#include "../../plugins/land/odometer.hpp"
#include "../../plugins/land/zero_rate.hpp"
#include "../../plugins/land/zupt.hpp"

#include <cmath>
#include <string>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace land_test {

using namespace binnacle;
using namespace binnacle::land;
using namespace binnacle::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double degree = M_PI / 180;

std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

struct Bench {
  AdditiveKind velocity{"velocity.ned", 3, "m/s"}, two{2, "rad"}, three{3, "rad"}, bias{3, "rad/s"}, scale{1, "1"},
      compliance{2, "rad*s^2/m"};
  AttitudeKind attitude;
  PositionKind position;

  Ports with(const AdditiveKind* zeta) const {
    Ports ports{{"velocity", &velocity}, {"attitude", &attitude}};
    if (zeta) ports["misalignment"] = zeta;
    return ports;
  }
  /// Velocity, attitude and misalignment of a place with everything askew.
  PortStates askew(const AdditiveKind* zeta) const {
    PortStates ports{{&velocity, {12.0, -9.0, 1.5}, 1.0, 1e-15},
                     {&attitude, numbers(strapdown::quaternion_from_euler({0.3, -0.2, -0.5})), 1e-2, 4e-16},
                     {}};
    if (zeta == &three) ports[2] = {zeta, {0.2, -0.3, 0.25}, 1e-2, 1e-16};
    if (zeta == &two) ports[2] = {zeta, {-0.3, 0.25}, 1e-2, 1e-16};
    return ports;
  }
};

SampleView at(double t, const std::vector<double>& fields = {}) {
  SampleView sample;
  sample.t = nanoseconds(t);
  sample.fields = fields.data();
  return sample;
}

Measured measured(const MeasurementModel& model, const SampleView& sample, const PortStates& ports,
                  const Driving& context = {}) {
  Complaints out;
  Measured m = linearize(model, sample, ports, context, out);
  REQUIRE_NO_COMPLAINTS(out);
  return m;
}

}  // namespace

TEST_CASE("nhc: Jacobians, with and without the misalignment, all axes and one") {
  const Bench bench;
  for (const AdditiveKind* zeta : {static_cast<const AdditiveKind*>(nullptr), &bench.two, &bench.three})
    for (const char* axes : {"yz", "y", "z"}) {
      INFO(axes << ", " << (zeta ? zeta->declaration().kind : "no misalignment"));
      const auto model = bind<Nhc>({{{"sigma", {0.2, 0.3}}, {"axes", axes}}, bench.with(zeta), {}});
      REQUIRE(model->declaration().read_ports.size() == (zeta ? 3 : 2));
      REQUIRE_NO_COMPLAINTS(check_measurement(*model, Nhc::spec(), at(1), bench.askew(zeta), {}, {1e-8}, 1e-13));
    }
}

TEST_CASE("nhc: the constraint is met by a vehicle that is mounted as paper 001 (5) and (7) say") {
  const Bench bench;
  const Vector3d zeta{0, -10.7e-3, 1e-3};
  const double v_x = 20;
  // (7): in the IMU's axes the vehicle moves with −ζ_z v_x to the right and +ζ_y v_x down.
  const Vector3d v_b{v_x, -zeta[2] * v_x, zeta[1] * v_x};
  const auto q_nb = strapdown::quaternion_from_euler({0.02, 0.03, 2.0});
  const Vector3d v_n = strapdown::dcm_from_quaternion(q_nb) * v_b;
  PortStates ports{{&bench.velocity, numbers(v_n)}, {&bench.attitude, numbers(q_nb)}, {&bench.three, numbers(zeta)}};
  const auto knows = bind<Nhc>({{{"sigma", 0.2}}, bench.with(&bench.three), {}});
  const Measured m = measured(*knows, at(1), ports);
  REQUIRE(m.residual.cwiseAbs().maxCoeff() < v_x * zeta.squaredNorm());
  // (9) with δ = truth − estimate: h_y grows with ζ_z, h_z falls with ζ_y, by the speed.
  REQUIRE(std::abs(m.H[2](0, 2) - v_x) < 0.01 * v_x);
  REQUIRE(std::abs(m.H[2](1, 1) + v_x) < 0.01 * v_x);
  REQUIRE(std::abs(m.H[2](0, 1)) < 0.02 * v_x);

  // Who does not know the mounting takes these velocities for errors.
  ports[2] = {};
  const auto ignorant = bind<Nhc>({{{"sigma", 0.2}}, bench.with(nullptr), {}});
  const Measured wrong = measured(*ignorant, at(1), ports);
  REQUIRE(std::abs(wrong.residual[0] - zeta[2] * v_x) < 1e-12);
  REQUIRE(std::abs(wrong.residual[1] + zeta[1] * v_x) < 1e-12);
}

TEST_CASE("nhc: its own misalignment port is that of a mounted attitude") {
  const Bench bench;
  PortStates ports = bench.askew(&bench.three);
  const auto own = bind<Nhc>({{{"sigma", 0.2}}, bench.with(&bench.three), {}});
  const Measured by_port = measured(*own, at(1), ports);

  const auto mounted = bind<frames::MountedAttitude>(
      {nlohmann::json::object(), {{"attitude", &bench.attitude}, {"misalignment", &bench.three}}, {}});
  std::vector<double> q(4);
  Matrix3d by_attitude, by_zeta;
  MatrixView J[] = {{by_attitude.data(), 3, 3, 3}, {by_zeta.data(), 3, 3, 3}};
  const double* x[] = {ports[1].x.data(), ports[2].x.data()};
  DerivedOutput evaluated{{q.data(), 4}, J};
  REQUIRE(mounted->evaluate({x, {}}, evaluated));
  ports[1].x = q;
  ports[2] = {};
  const auto plain = bind<Nhc>({{{"sigma", 0.2}}, bench.with(nullptr), {}});
  const Measured by_block = measured(*plain, at(1), ports);
  REQUIRE((by_block.residual - by_port.residual).norm() < 1e-12);
  REQUIRE((by_block.H[0] - by_port.H[0]).norm() < 1e-12);
  REQUIRE((by_block.H[1] * by_attitude - by_port.H[1]).norm() < 1e-12);
  REQUIRE((by_block.H[1] * by_zeta - by_port.H[2]).norm() < 1e-12);
}

TEST_CASE("nhc: springs and tyres give way under the specific force") {
  const Bench bench;
  auto ports_of = bench.with(&bench.three);
  ports_of["compliance"] = &bench.compliance;
  PortStates ports = bench.askew(&bench.three);
  ports.push_back({&bench.compliance, {-0.008, 0.005}, 1e-3, 1e-16});
  const std::vector<double> forces{3, 2}, unknown{3, std::nan("")};  // fy, fx
  for (const char* axes : {"yz", "y", "z"}) {
    INFO(axes);
    const auto model = bind<Nhc>({{{"sigma", 0.2}, {"axes", axes}}, ports_of, {}});
    REQUIRE(model->declaration().read_ports.size() == 4);
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, Nhc::spec(), at(1, forces), ports, {}, {1e-8}, 1e-13));
    REQUIRE(measured(*model, at(1, unknown), ports).result.refusal == Refusal::invalid);
  }
  // In a turn to the right a car slips to the left; where it accelerates, its nose rises, and it moves down in its own axes.
  const double v_x = 20;
  const Vector3d v_v{v_x, -0.008 * 3 * v_x, 0.005 * 2 * v_x};
  ports = {{&bench.velocity, numbers(v_v)}, {&bench.attitude, {1, 0, 0, 0}}, {}, {&bench.compliance, {-0.008, 0.005}}};
  ports_of.erase("misalignment");
  const auto model = bind<Nhc>({{{"sigma", 0.2}}, ports_of, {}});
  REQUIRE(measured(*model, at(1, forces), ports).residual.norm() < 1e-14);
  // Without the forces there is no such model.
  REQUIRE_THROWS_AS(bind<Nhc>({{{"sigma", 0.2}}, ports_of, {"fx"}}), ComponentError);
}

TEST_CASE("nhc: R grows with the speed and with what is felt of a turn") {
  const Bench bench;
  const auto model = bind<Nhc>(
      {{{"sigma", {0.2, 0.3}}, {"angle", 0.01}, {"slip", 0.003}, {"max_turn_rate", 0.5}}, bench.with(nullptr), {}});
  const PortStates ports = bench.askew(nullptr);
  const double v2 = 144 + 81 + 2.25;
  const Vector3d turning{0, 0.06, -0.08};
  const Measured m = measured(*model, at(1), ports, {0, turning.data()});
  REQUIRE(std::abs(m.R(0, 0) - (0.04 + 1e-4 * v2 + std::pow(0.003 * 0.1 * v2, 2))) < 1e-12);
  REQUIRE(std::abs(m.R(1, 1) - (0.09 + 1e-4 * v2)) < 1e-12);
  REQUIRE(m.R(0, 1) == 0);
  const Vector3d wild{0, 0.4, 0.4};
  REQUIRE(measured(*model, at(1), ports, {0, wild.data()}).result.refusal == Refusal::unsupported);
  REQUIRE(measured(*model, at(1), ports).result.refusal == Refusal::unsupported);
}

TEST_CASE("nhc: R grows with the turn rate in both rows, and with the lateral specific force in y alone") {
  const Bench bench;
  const auto model = bind<Nhc>({{{"sigma", {0.2, 0.3}}, {"turn", 0.5}, {"lateral", 0.02}}, bench.with(nullptr), {}});
  const PortStates ports = bench.askew(nullptr);
  // Driving rates wx, wy, wz, fy: |w| = 0.1 rad/s.
  const auto R = [&](double wz, double fy) {
    const Eigen::Vector4d rates{0, 0.06, wz, fy};
    return measured(*model, at(1), ports, {0, rates.data()}).R;
  };
  const auto curve = R(-0.08, -3), straight = R(-0.08, 0), other_way = R(0.08, 3);
  REQUIRE(std::abs(curve(0, 0) - (0.04 + 0.05 * 0.05 + 0.06 * 0.06)) < 1e-12);
  REQUIRE(std::abs(curve(1, 1) - (0.09 + 0.05 * 0.05)) < 1e-12);
  REQUIRE(std::abs(straight(0, 0) - (0.04 + 0.05 * 0.05)) < 1e-12);
  REQUIRE(other_way == curve);
  // Not known, and so refused: never taken for none.
  REQUIRE(measured(*model, at(1), ports).result.refusal == Refusal::unsupported);
  const Eigen::Vector4d no_force{0, 0, 0.1, std::nan("")}, no_rate{0, 0, std::nan(""), 1};
  REQUIRE(measured(*model, at(1), ports, {0, no_force.data()}).result.refusal == Refusal::unsupported);
  REQUIRE(measured(*model, at(1), ports, {0, no_rate.data()}).result.refusal == Refusal::unsupported);
  const auto by_turn = bind<Nhc>({{{"sigma", 0.2}, {"turn", 0.5}}, bench.with(nullptr), {}});
  REQUIRE(measured(*by_turn, at(1), ports, {0, no_force.data()}).result.refusal == Refusal::none);
}

TEST_CASE("nhc and zupt: refusals, and samples too near to the last") {
  const Bench bench;
  const auto model = bind<Nhc>({{{"sigma", 0.2}, {"spacing", 1.0}, {"min_speed", 3.0}}, bench.with(nullptr), {}});
  PortStates ports = bench.askew(nullptr);
  std::vector<std::byte> memory(model->declaration().memory_bytes);
  REQUIRE(memory.size() == 8);
  model->start(memory.data());
  const auto refusal = [&](const MeasurementModel& of, double t) {
    const int rows = of.declaration().max_rows;
    std::vector<double> r(static_cast<std::size_t>(rows)), S(static_cast<std::size_t>(rows * rows));
    const auto x = detail::pointers(ports);
    MeasurementOutput out{0, {r.data(), rows}, {}, {S.data(), rows, rows, rows}};
    return of.linearize({at(t), {}, x.data(), {}, memory.data(), {}, {}}, out).refusal;
  };
  REQUIRE(refusal(*model, 10.0) == Refusal::none);
  REQUIRE(refusal(*model, 10.5) == Refusal::unsupported);
  REQUIRE(refusal(*model, 10.995) == Refusal::unsupported);
  REQUIRE(refusal(*model, 11.0) == Refusal::none);
  ports[0].x = {1.0, -2.0, 0.5};
  REQUIRE(refusal(*model, 20.0) == Refusal::unsupported);

  const auto zupt = bind<Zupt>({{{"sigma", 0.02}, {"spacing", 1.0}}, {{"velocity", &bench.velocity}}, {}});
  zupt->start(memory.data());
  REQUIRE(refusal(*zupt, 10.0) == Refusal::none);
  REQUIRE(refusal(*zupt, 10.5) == Refusal::unsupported);
  REQUIRE(refusal(*zupt, 11.0) == Refusal::none);
  REQUIRE(bind<Zupt>({{{"sigma", 0.02}}, {{"velocity", &bench.velocity}}, {}})->declaration().memory_bytes == 0);
  REQUIRE_THROWS_AS(bind<Nhc>({{{"sigma", 0.2}}, bench.with(&bench.scale), {}}), ComponentError);
}

TEST_CASE("zupt: minus the velocity") {
  const Bench bench;
  const auto model = bind<Zupt>({{{"sigma", {0.01, 0.02, 0.03}}}, {{"velocity", &bench.velocity}}, {}});
  const PortStates ports{{&bench.velocity, {0.1, -0.2, 0.3}}};
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, Zupt::spec(), at(1), ports, {}, {1e-9}));
  const Measured m = measured(*model, at(1), ports);
  REQUIRE((m.residual - Vector3d(-0.1, 0.2, -0.3)).norm() < 1e-15);
  REQUIRE(std::abs(m.R(2, 2) - 9e-4) < 1e-15);
}

TEST_CASE("level: minus the roll, and its Jacobian at any heading and pitch") {
  const Bench bench;
  const auto model = bind<Level>({{{"sigma", 0.1}}, {{"attitude", &bench.attitude}}, {}});
  for (const double yaw : {-2.0, 0.0, 0.5, 3.0})
    for (const double pitch : {-0.6, 0.2}) {
      const PortStates ports{
          {&bench.attitude, numbers(strapdown::quaternion_from_euler({0.3, pitch, yaw})), 1e-2, 4e-16}};
      REQUIRE_NO_COMPLAINTS(check_measurement(*model, Level::spec(), at(1), ports, {}, {1e-3}));
      const Measured m = measured(*model, at(1), ports);
      REQUIRE(std::abs(m.residual[0] + 0.3) < 1e-14);
      REQUIRE(std::abs(m.R(0, 0) - 0.01) < 1e-15);
    }
  const PortStates upright{{&bench.attitude, numbers(strapdown::quaternion_from_euler({0, M_PI / 2, 0}))}};
  REQUIRE(measured(*model, at(1), upright).result.refusal == Refusal::unsupported);
}

TEST_CASE("zero rate: Jacobians, and a gyroscope at rest feels the earth and its bias") {
  const Bench bench;
  const Ports all{{"gyro_bias", &bench.bias}, {"attitude", &bench.attitude}, {"position", &bench.position}};
  const auto model = bind<ZeroRate>({{{"sigma", 1e-5}}, all, {}});
  const Vector3d lla{0.7, 2.2, 60}, bias{1e-5, -2e-5, 3e-5};
  const auto q = strapdown::quaternion_from_euler({0.1, -0.2, 1.3});
  const Vector3d omega = strapdown::dcm_from_quaternion(q).transpose() * strapdown::omega_ie_n(lla[0]) + bias;
  const PortStates ports{{&bench.bias, numbers(bias), 1e-5, 1e-20},
                         {&bench.attitude, numbers(q), 1e-2, 4e-16},
                         {&bench.position, numbers(lla), 1e4, 4e-9}};
  const std::vector<double> fields = numbers(omega);
  REQUIRE(measured(*model, at(1, fields), ports).residual.norm() < 1e-18);
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, ZeroRate::spec(), at(1, fields), ports, {}, {1e-5}, 1e-19));

  const auto coarse = bind<ZeroRate>({{{"sigma", 1e-5}}, {{"gyro_bias", &bench.bias}}, {}});
  const Measured without = measured(*coarse, at(1, fields), {ports[0], {}, {}});
  REQUIRE((without.residual - (omega - bias)).norm() < 1e-18);
  REQUIRE_THROWS_AS(bind<ZeroRate>(
                        {{{"sigma", 1e-5}}, {{"gyro_bias", &bench.bias}, {"attitude", &bench.attitude}}, {}}),
                    ComponentError);
  const std::vector<double> bad{0, std::nan(""), 0};
  REQUIRE(measured(*model, at(1, bad), ports).result.refusal == Refusal::invalid);
}

TEST_CASE("odometer: Jacobians, scale factor, refusals") {
  const Bench bench;
  for (const AdditiveKind* zeta : {static_cast<const AdditiveKind*>(nullptr), &bench.two, &bench.three})
    for (const bool scaled : {false, true}) {
      Ports plugged = bench.with(zeta);
      PortStates ports = bench.askew(zeta);
      ports.push_back({});
      if (scaled) plugged["scale"] = &bench.scale, ports[3] = {&bench.scale, {0.05}, 1e-2, 1e-17};
      const auto model = bind<Odometer>({{{"sigma", 0.1}, {"relative", 0.02}, {"min_speed", 1.0}}, plugged, {}});
      const std::vector<double> z{15};
      REQUIRE_NO_COMPLAINTS(check_measurement(*model, Odometer::spec(), at(1, z), ports, {}, {1e-8}, 1e-13));
      const Measured m = measured(*model, at(1, z), ports);
      REQUIRE(std::abs(m.R(0, 0) - (0.01 + 0.09)) < 1e-12);
    }
  // At 20 m/s a sensor that reports 2 % too much shows 20.4 m/s.
  Ports plugged = bench.with(nullptr);
  plugged["scale"] = &bench.scale;
  const auto model = bind<Odometer>({{{"sigma", 0.1}, {"min_speed", 1.0}}, plugged, {}});
  const PortStates ports{{&bench.velocity, {0, 20, 0}},
                         {&bench.attitude, numbers(strapdown::quaternion_from_euler({0, 0, 90 * degree}))},
                         {},
                         {&bench.scale, {0.02}}};
  const std::vector<double> z{20.4}, slow{0.5}, bad{std::nan("")};
  REQUIRE(std::abs(measured(*model, at(1, z), ports).residual[0]) < 1e-12);
  REQUIRE(measured(*model, at(1, slow), ports).result.refusal == Refusal::unsupported);
  REQUIRE(measured(*model, at(1, bad), ports).result.refusal == Refusal::invalid);
}

}  // namespace land_test
