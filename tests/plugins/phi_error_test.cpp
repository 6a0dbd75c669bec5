// SPDX-License-Identifier: Apache-2.0
// Plugin phi_error: every block of Φ and Q, samples, fragments and gaps.
#include "../../plugins/phi_error/phi_error_process.hpp"

#include <cmath>
#include <random>

#include "inertial_bench.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace phi_error_test {

using namespace binnacle;
using namespace binnacle::phi_error;
using namespace binnacle::test;
using Eigen::Vector3d;

namespace {

using Bench = InertialBench<PhiErrorProcess>;

}  // namespace

TEST_CASE("transition: every block against differences of the mechanization", "[phi_error]") {
  // The shortest step, with a wide difference, shows the small terms: gravity by latitude, the ellipsoid's radii.
  for (const auto& [dt, metres] : {std::pair(0.01, 100.0), std::pair(0.002, 100.0), std::pair(1e-4, 2e3)})
    for (const Flight& flight : flights)
      for (const bool with_sensor_errors : {true, false})
        for (const auto& [order, power] : {std::pair("first", 2), std::pair("second", 3)}) {
          INFO(flight.name << ", sensor errors " << with_sensor_errors << ", order " << order << ", dt " << dt);
          Samples samples(flight);
          const Bench bench(order, with_sensor_errors);
          PortStates ports = bench.ports(flight);
          ports[0].scale.setConstant(metres);
          // Relative to each block's largest element: what is left out is one power of dt higher, the more so as the
          // rates change by several times themselves per second.
          const Tolerance tolerance{6 * dt, 20 * std::pow(dt, power)};
          REQUIRE_NO_COMPLAINTS(bench.check().transition(ports, samples.whole(0, dt).step(),
                                                         memory_before(bench, flight, dt), tolerance));
        }
}

TEST_CASE("transition: the stated order in dt, for one sample and for several", "[phi_error]") {
  for (const auto& [order, least] : {std::pair("first", 1.8), std::pair("second", 2.8)}) {
    const Bench bench(order);
    for (const Flight& flight : flights) {
      const auto error = [&](double dt, int count) {
        Samples samples(flight);
        for (int i = 0; i < count; ++i) samples.whole(i * dt / count, (i + 1) * dt / count);
        return bench.check().transition_error(bench.ports(flight), samples.step(), memory_before(bench, flight, dt));
      };
      for (const int count : {1, 3}) {
        INFO(flight.name << ", order " << order << ", samples " << count);
        const double coarse = error(0.08, count), fine = error(0.02, count);
        INFO("errors " << coarse << ", " << fine);
        REQUIRE(std::log2(coarse / fine) / 2 > least);
      }
    }
  }
}

TEST_CASE("noise: every block of Q against fine integration", "[phi_error]") {
  struct Case {
    const char* name;
    nlohmann::json gyro, accel;
  };
  // With gyro noise alone Q is what it brings to velocity and position, which is little beside accelerometer noise.
  for (const Case& c : {Case{"both", {0.03, 0.02, 0.01}, {0.1, 0.2, 0.3}}, Case{"gyro", {0.03, 0.02, 0.01}, {0, 0, 0}},
                        Case{"accelerometer", {1e-5, 1e-5, 1e-5}, {0.1, 0.2, 0.3}}})
    for (const Flight& flight : flights) {
      INFO(c.name << ", " << flight.name);
      const double dt = 0.02;
      Samples samples(flight);
      const Step whole = samples.whole(0, dt).step();
      Samples fragments(flight);
      constexpr int count = 200;
      for (int i = 0; i < count; ++i) fragments.part(i * dt / count, (i + 1) * dt / count, 0, dt);
      const Bench second("second", false, c.gyro, c.accel);
      // The sum over n short steps of Q right in leading powers lacks 1/(2 n) of the integrals.
      REQUIRE_NO_COMPLAINTS(second.check().noise(second.ports(flight), whole, fragments.steps(),
                                                 memory_before(second, flight, dt), 0.04, 1e-3));
      if (std::string(c.name) != "both") continue;
      const Bench first("first", false, c.gyro, c.accel);
      REQUIRE(first.model->declaration().noise.size() == 2);
      REQUIRE_NO_COMPLAINTS(first.check().noise(first.ports(flight), whole, fragments.steps(),
                                                memory_before(first, flight, dt), 0.04, 1.0));
    }
}

TEST_CASE("noise: its size after a second is the random walk of its unit", "[phi_error]") {
  const Flight still{"still", {0.6, 2, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, -9.8}, {0, 0, 0}, {0, 0, 0}};
  const Bench bench("second", false, {0.01, 0.01, 0.02}, {0.3, 0.3, 0.5});
  Samples samples(still);
  Complaints out;
  const auto p =
      bench.check().propagate(bench.ports(still), samples.whole(0, 0.01).step(), bench.check().fresh_memory(), out);
  REQUIRE(std::abs(std::sqrt(100 * p.noise.at({2, 2})(2, 2)) - 0.02) < 1e-8);
  REQUIRE(std::abs(std::sqrt(100 * p.noise.at({1, 1})(2, 2)) - 0.5) < 1e-6);
}

// At rest and level v̇ = (−g φ_east, g φ_north, 0): what a constant rate r and acceleration a leave after T.
TEST_CASE("noise: a bridged step adds what the vehicle may have done, whole and in parts", "[phi_error]") {
  const double g = 9.8, T = 2, a = 0.7;
  const Vector3d r(0.01, 0.02, 0.04);
  const Flight still{"still", {0.6, 2, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, -g}, {0, 0, 0}, {0, 0, 0}};
  const Bench bench("second", false, 0, 0, {{"bridge", {{"acceleration", a}, {"rate", {r[0], r[1], r[2]}}}}});
  const auto noise = [&](double from, double to, bool bridges) {
    Samples samples(still);
    samples.part(from, to, 0, T).bridge(bridges);
    Complaints out;
    return bench.check().propagate(bench.ports(still), samples.step(), bench.check().fresh_memory(), out).noise;
  };
  REQUIRE(noise(0, T, false).at({2, 2}).norm() == 0);

  const auto whole = noise(0, T, true);
  const Eigen::Matrix3d phi = whole.at({2, 2}), v = whole.at({1, 1}), v_phi = whole.at({1, 2});
  for (int i = 0; i < 3; ++i) REQUIRE(std::abs(phi(i, i) / std::pow(r[i] * T, 2) - 1) < 1e-3);
  const double of_turn = g * g * std::pow(T, 4) * (1.0 / 3 + 1.0 / 3);  // f turned with the vehicle; f as it was
  REQUIRE(std::abs(v(0, 0) / (std::pow(a * T, 2) + of_turn * r[1] * r[1]) - 1) < 1e-3);
  REQUIRE(std::abs(v(1, 1) / (std::pow(a * T, 2) + of_turn * r[0] * r[0]) - 1) < 1e-3);
  REQUIRE(std::abs(v(2, 2) / std::pow(a * T, 2) - 1) < 1e-3);
  REQUIRE(std::abs(v_phi(0, 1) / (-g * std::pow(r[1], 2) * std::pow(T, 3) / 2) - 1) < 1e-3);
  REQUIRE(std::abs(v_phi(1, 0) / (g * std::pow(r[0], 2) * std::pow(T, 3) / 2) - 1) < 1e-3);

  const Eigen::Matrix3d parts = noise(0, 0.3, true).at({2, 2}) + noise(0.3, T, true).at({2, 2});
  REQUIRE((parts - phi).cwiseAbs().maxCoeff() < 1e-3 * phi.cwiseAbs().maxCoeff());
}

// A line through the rates before the hole and those held over it would be a motion that nobody measured.
TEST_CASE("a bridge has no neighbour", "[phi_error]") {
  const Flight flight = flights[0];
  const Bench bench;
  Samples samples(flight);
  samples.whole(0, 2);
  const auto place = [&](const std::vector<std::byte>& memory, bool bridges) {
    Complaints out;
    samples.bridge(bridges);
    return bench.check().propagate(bench.ports(flight), samples.step(), memory, out).x_plus;
  };
  const auto memory = memory_before(bench, flight, 0.1);
  REQUIRE(place(memory, true) == place(bench.check().fresh_memory(), true));
  REQUIRE(place(memory, false) != place(bench.check().fresh_memory(), false));
}

TEST_CASE("several samples at once are the same as one after another", "[phi_error]") {
  const Bench bench;
  for (const Flight& flight : flights) {
    INFO(flight.name);
    Samples samples(flight);
    samples.whole(0, 0.01).whole(0.01, 0.018).whole(0.018, 0.03).whole(0.03, 0.04);
    const PortStates ports = bench.ports(flight);
    const auto memory = memory_before(bench, flight, 0.01);
    Complaints out;
    const Propagation group = bench.check().propagate(ports, samples.step(), memory, out);
    const Walked one_by_one = walk(bench, ports, samples.steps(), memory);
    REQUIRE_NO_COMPLAINTS(out);
    for (std::size_t i = 0; i < 3; ++i) REQUIRE(group.x_plus[i] == one_by_one.ports[i].x);
    REQUIRE(group.memory == one_by_one.memory);
    // Q of the group is the sum over its samples, exactly, but for blocks of Φ that are not declared.
    REQUIRE_NO_COMPLAINTS(bench.check().noise(ports, samples.step(), samples.steps(), memory, 1e-9, 1e-9));
    REQUIRE_NO_COMPLAINTS(bench.check().transition(ports, samples.step(), memory, {0.06, 20 * 6.4e-5}));
  }
}

TEST_CASE("a sample cut at a measurement's time ends where the whole one does", "[phi_error]") {
  const Bench bench;
  for (const Flight& flight : flights) {
    INFO(flight.name);
    const double dt = 0.01;
    const PortStates ports = bench.ports(flight);
    const auto memory = memory_before(bench, flight, dt);
    Samples whole(flight), cut(flight);
    whole.whole(0, dt).whole(dt, 2 * dt);
    cut.part(0, 0.003, 0, dt).part(0.003, 0.0071, 0, dt).part(0.0071, dt, 0, dt).whole(dt, 2 * dt);
    const Walked a = walk(bench, ports, whole.steps(), memory);
    const Walked b = walk(bench, ports, cut.steps(), memory);
    REQUIRE(distance(bench, a.ports, b.ports) < 3e-7);
    // Had the fragments passed for samples, the coning term alone would be off by more.
    Samples mistaken(flight);
    mistaken.part(0, 0.003, 0, dt).part(0.003, 0.0071, 0, dt).part(0.0071, dt, 0, dt).whole(dt, 2 * dt);
    std::vector<Step> steps = mistaken.steps();
    std::vector<InputSample> alone;
    for (const Step& step : steps) alone.push_back(step.samples[0]);
    for (std::size_t i = 0; i < alone.size(); ++i) {
      alone[i].whole_t0 = alone[i].t0, alone[i].whole_t1 = alone[i].t1;
      steps[i].samples = {&alone[i], 1};
    }
    const Walked c = walk(bench, ports, steps, memory);
    REQUIRE(distance(bench, a.ports, c.ports) > 3 * distance(bench, a.ports, b.ports));
  }
}

TEST_CASE("after a gap nothing is remembered", "[phi_error]") {
  const Bench bench;
  const Flight& flight = flights[1];
  const PortStates ports = bench.ports(flight);
  const auto check = bench.check();
  Samples later(flight);
  const Step step = later.whole(0.5, 0.51).step();
  Complaints out;
  const auto after_gap = check.propagate(ports, step, memory_before(bench, flight, 0.01), out);
  const auto fresh = check.propagate(ports, step, check.fresh_memory(), out);
  REQUIRE(after_gap.x_plus == fresh.x_plus);
  Samples next(flight);
  const Step contiguous = next.whole(0, 0.01).step();
  const auto with_neighbour = check.propagate(ports, contiguous, memory_before(bench, flight, 0.01), out);
  const auto without = check.propagate(ports, contiguous, check.fresh_memory(), out);
  REQUIRE(with_neighbour.x_plus != without.x_plus);
}

TEST_CASE("what the sensors are known to do wrong is taken off, from the neighbour too", "[phi_error]") {
  // The same flight by perfect sensors, and by sensors whose errors are the ones plugged in.
  const Bench plain("second", false), corrected;
  for (const Flight& flight : flights) {
    Flight measured = flight;
    const PortStates ports = corrected.ports(flight);
    const auto apply = [&](Vector3d& v, Vector3d& rate, std::size_t bias, std::size_t scale) {
      const Vector3d gain = 1.0 + vector_at<3>(ports[scale].x.data()).array();
      v = gain.cwiseProduct(v) + vector_at<3>(ports[bias].x.data());
      rate = gain.cwiseProduct(rate);
    };
    apply(measured.omega, measured.omega_rate, 3, 5);
    apply(measured.f, measured.f_rate, 4, 6);
    Samples truth(flight), seen(measured);
    for (int i = 0; i < 5; ++i) truth.whole(0.01 * i, 0.01 * (i + 1)), seen.whole(0.01 * i, 0.01 * (i + 1));
    const Walked a = walk(plain, plain.ports(flight), truth.steps(), plain.check().fresh_memory());
    const Walked b = walk(corrected, ports, seen.steps(), corrected.check().fresh_memory());
    REQUIRE(distance(corrected, a.ports, b.ports) < 1e-8);
    const Walked c = walk(plain, plain.ports(flight), seen.steps(), plain.check().fresh_memory());
    REQUIRE(distance(corrected, a.ports, c.ports) > 1e-3);
  }
}

TEST_CASE("at rest on the turning earth it stays at rest", "[phi_error]") {
  const Vector3d lla{0.65, 2.2, 60}, angles{0.1, -0.2, 1.0};
  const Eigen::Matrix3d C_bn = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(angles)).transpose();
  const Flight rest{"rest",
                    lla,
                    Vector3d::Zero(),
                    angles,
                    C_bn * strapdown::omega_ie_n(lla[0]),
                    C_bn * Vector3d(0, 0, -strapdown::gravity(lla[0], lla[2]).down),
                    Vector3d::Zero(),
                    Vector3d::Zero()};
  const Bench bench("second", false);
  Samples samples(rest);
  for (int i = 0; i < 1000; ++i) samples.whole(0.01 * i, 0.01 * (i + 1));
  const PortStates start = bench.ports(rest);
  REQUIRE(distance(bench, walk(bench, start, samples.steps(), bench.check().fresh_memory()).ports, start) < 1e-8);
}

TEST_CASE("dt = 0 changes nothing, and a pole stops it with a reason", "[phi_error]") {
  const Bench bench;
  const auto check = bench.check();
  Samples nothing(flights[0]);
  REQUIRE_NO_COMPLAINTS(
      check.zero_step(bench.ports(flights[0]), nothing.whole(0, 0).step(), memory_before(bench, flights[0], 0.01)));
  Flight pole = flights[0];
  pole.lla[0] = 90 * degree - 1e-6;
  Samples samples(pole);
  Complaints out;
  const Step step = samples.whole(0, 0.01).step();
  auto memory = check.fresh_memory();
  const PortStates ports = bench.ports(pole);
  std::array<double, 10> x_plus;
  double* at[] = {x_plus.data(), x_plus.data() + 3, x_plus.data() + 6, nullptr, nullptr, nullptr, nullptr};
  const auto x = test::detail::pointers(ports);
  ProcessOutput values{at, {}, {}};
  const SampleView no_statement;
  const Result result = bench.model->propagate({step, x.data(), &no_statement, memory.data(), {}}, values);
  REQUIRE(result.refusal == Refusal::failed);
  REQUIRE(std::string(result.reason).find("pole") != std::string::npos);
}

TEST_CASE("phi_error: without errors of the position the other blocks keep their bits", "[phi_error]") {
  check_frozen_position<PhiErrorProcess>();
}

}  // namespace phi_error_test
