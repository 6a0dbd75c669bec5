// SPDX-License-Identifier: Apache-2.0
// The attitude algorithm as a choice of mechanizations: what binds, orders, groups that were cut, Jacobians.
#include "../../plugins/attitude_only/attitude_only.hpp"
#include "../../plugins/phi_error/phi_error_process.hpp"
#include "../../plugins/psi_error/psi_error_process.hpp"

#include <array>
#include <cmath>

#include "inertial_bench.hpp"
#include "simulation/quadrature.hpp"
#include "support/navigation_kinds.hpp"

namespace attitude_choice_test {

using namespace binnacle;
using namespace binnacle::test;
using attitude_only::AttitudeOnly;
using Eigen::Vector3d;
using Eigen::Vector4d;
using nlohmann::json;

namespace {

using PhiBench = InertialBench<phi_error::PhiErrorProcess>;
using PsiBench = InertialBench<psi_error::PsiErrorProcess>;

json chosen(int samples, const std::string& form = "coning", const std::string& precision = "double") {
  return {{"attitude", {{"samples", samples}, {"form", form}, {"precision", precision}}}};
}
template <class Bench>
Bench bench_with(const json& choice, const std::string& order = "second", bool with_sensor_errors = true) {
  return Bench(order, with_sensor_errors, {0.03, 0.02, 0.01}, {0.1, 0.2, 0.3}, choice);
}

/// A rate that turns and swells: ω(t), and what it makes of an attitude, by a fine Taylor of quaternions.
Vector3d smooth_rate(double t, double size) {
  return size * Vector3d(std::sin(1.3 * t), 0.7 * std::cos(0.9 * t + 0.3), 0.4 + 0.8 * std::sin(2.1 * t - 1));
}
Vector3d smooth_increment(double t0, double t1, double size) {
  Vector3d sum = Vector3d::Zero();
  simulation::for_each_node<simulation::Gauss8>(t0, t1, [&](double t, double w) { sum += w * smooth_rate(t, size); });
  return sum;
}
Vector4d product(const Vector4d& q, const Vector4d& p) { return strapdown::quaternion_product(q, p); }

Vector4d integrated(double size, double duration) {
  constexpr int steps = 20000;
  const double h = duration / steps;
  const auto slope = [&](double t, const Vector4d& q) -> Vector4d {
    const Vector3d w = smooth_rate(t, size);
    return 0.5 * product(q, {0, w[0], w[1], w[2]});
  };
  Vector4d q(1, 0, 0, 0);
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const Vector4d a = slope(t, q), b = slope(t + h / 2, q + h / 2 * a), c = slope(t + h / 2, q + h / 2 * b),
                   d = slope(t + h, q + h * c);
    q += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return q.normalized();
}

/// attitude_only over `duration` in updates of `samples` that lie h/samples apart.
Vector4d walked(const json& choice, int samples, double size, double duration, int updates) {
  const AttitudeKind block;
  const auto model = bind<AttitudeOnly>({choice, {{"attitude", &block}}, {}, samples});
  std::vector<std::byte> memory(model->declaration().memory_bytes);
  Vector4d q(1, 0, 0, 0);
  const double length = duration / (updates * samples);
  for (int u = 0; u < updates; ++u) {
    std::vector<std::array<double, 3>> fields(static_cast<std::size_t>(samples));
    std::vector<InputSample> inputs(fields.size());
    for (int i = 0; i < samples; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double t0 = (u * samples + i) * length;
      vector_at<3>(fields[at].data()) = smooth_increment(t0, t0 + length, size);
      inputs[at] = {nanoseconds(t0), nanoseconds(t0 + length), length,
                    nanoseconds(t0), nanoseconds(t0 + length), fields[at].data()};
    }
    const Step step{inputs.front().t0, inputs.back().t1, length * samples, inputs};
    const double* x[] = {q.data()};
    Vector4d x_plus;
    Eigen::Matrix3d Q;
    double* out_x[] = {x_plus.data()};
    double* out_Q[] = {Q.data()};
    ProcessOutput out{out_x, {}, out_Q};
    REQUIRE(model->propagate({step, x, {}, memory.data(), {}}, out));
    q = x_plus;
  }
  return q;
}

}  // namespace

TEST_CASE("samples that are not those of a step are refused, with the pointer", "[attitude]") {
  const AttitudeKind block;
  const auto attempt = [&](const json& choice, int per_step) -> std::string {
    try {
      bind<AttitudeOnly>({choice, {{"attitude", &block}}, {}, per_step});
    } catch (const ComponentError& error) {
      CHECK(error.pointer() == "/attitude/samples");
      return error.what();
    }
    return {};
  };
  CHECK(attempt(chosen(4), 4).empty());
  CHECK(attempt(chosen(1), 1).empty());
  CHECK(attempt(json::object(), 3).empty());
  CHECK(attempt(chosen(4), 1) ==
        "the attitude algorithm takes 4 samples, and 'samples_per_step' of the process is 1: make them equal");
  CHECK_FALSE(attempt(chosen(1), 2).empty());
}

// From two samples on it is the terms of third order in θ, which no form has, that are left: of a motion of a radian a
// second all are of order 4. What more samples are better at is fast motion of small angles.
TEST_CASE("the order of each choice on a smooth motion", "[attitude]") {
  struct Case {
    json choice;
    int samples;
    double least, most;
  };
  json alone = chosen(1);
  alone["attitude"]["previous"] = false;
  const Case cases[] = {{alone, 1, 1.9, 2.1},
                        {chosen(1), 1, 2.9, 3.3},
                        {chosen(2), 2, 3.9, 4.1},
                        {chosen(3), 3, 3.9, 4.1},
                        {chosen(3, "polynomial"), 3, 3.9, 4.1},
                        {chosen(4), 4, 3.9, 4.1},
                        {chosen(4, "polynomial"), 4, 3.9, 4.1}};
  const Vector4d exact = integrated(1.0, 4.0);
  for (const Case& c : cases) {
    const auto error = [&](int updates) {
      return strapdown::attitude_minus(walked(c.choice, c.samples, 1.0, 4.0, updates), exact).norm();
    };
    const double coarse = error(20), fine = error(80), order = std::log2(coarse / fine) / 2;
    INFO(c.choice.dump() << ": errors " << coarse << ", " << fine << ", order " << order);
    CHECK(order > c.least);
    CHECK(order < c.most);
  }
}

TEMPLATE_TEST_CASE("transition of several samples: every block against differences", "[attitude]", PhiBench, PsiBench) {
  for (const auto& [samples, form] : {std::pair(2, "coning"), {3, "coning"}, {4, "coning"}, {4, "polynomial"}})
    for (const auto& [order, power] : {std::pair("first", 2), std::pair("second", 3)}) {
      const auto bench = bench_with<TestType>(chosen(samples, form), order);
      for (const Flight& flight : flights) {
        INFO(flight.name << ", " << samples << " samples, " << form << ", order " << order);
        const double dt = 0.01;
        Samples group(flight);
        for (int i = 0; i < samples; ++i) group.whole(i * dt / samples, (i + 1) * dt / samples);
        REQUIRE_NO_COMPLAINTS(bench.check().transition(bench.ports(flight), group.step(),
                                                       memory_before(bench, flight, dt / samples),
                                                       {6 * dt, 20 * std::pow(dt, power)}));
      }
    }
}

TEMPLATE_TEST_CASE("several samples: the order of the transition in the length of the group", "[attitude]", PhiBench,
                   PsiBench) {
  for (const auto& [order, least] : {std::pair("first", 1.8), std::pair("second", 2.8)})
    for (const int samples : {2, 4}) {
      const auto bench = bench_with<TestType>(chosen(samples), order);
      for (const Flight& flight : flights) {
        const auto error = [&](double dt) {
          Samples group(flight);
          for (int i = 0; i < samples; ++i) group.whole(i * dt / samples, (i + 1) * dt / samples);
          return bench.check().transition_error(bench.ports(flight), group.step(), memory_before(bench, flight, dt));
        };
        const double coarse = error(0.08), fine = error(0.02);
        INFO(flight.name << ", " << samples << " samples, order " << order << ": " << coarse << ", " << fine);
        CHECK(std::log2(coarse / fine) / 2 > least);
      }
    }
}

TEST_CASE("a group that was cut ends where the whole one does", "[attitude]") {
  for (const auto& [samples, form] : {std::pair(2, "coning"), {3, "coning"}, {4, "coning"}, {4, "polynomial"}}) {
    const auto bench = bench_with<PhiBench>(chosen(samples, form));
    for (const Flight& flight : flights) {
      const auto apart = [&, &samples = samples](double dt) {
        const PortStates ports = bench.ports(flight);
        const auto memory = memory_before(bench, flight, dt);
        Samples whole(flight), head(flight), first(flight), second(flight), tail(flight);
        for (int i = 0; i < samples; ++i) whole.whole(i * dt, (i + 1) * dt);
        // A measurement in the middle of the last sample but one; what is left over fills no group.
        const int cut = samples - 2;
        for (int i = 0; i < cut; ++i) head.whole(i * dt, (i + 1) * dt);
        first.part(cut * dt, (cut + 0.3) * dt, cut * dt, (cut + 1) * dt);
        second.part((cut + 0.3) * dt, (cut + 1) * dt, cut * dt, (cut + 1) * dt);
        tail.whole((cut + 1) * dt, samples * dt);
        std::vector<Step> steps;
        if (cut > 0) steps.push_back(head.step());
        steps.insert(steps.end(), {first.step(), second.step(), tail.step()});
        return distance(bench, walk(bench, ports, {whole.step()}, memory).ports,
                        walk(bench, ports, steps, memory).ports);
      };
      const double coarse = apart(0.02), fine = apart(0.01);
      INFO(samples << " samples, " << form << ", " << flight.name << ": " << coarse << ", " << fine);
      // Rates change linearly, so that all choices are right to O(h⁴), and the cut costs no more.
      CHECK(fine < 1e-5);
      CHECK(std::log2(coarse / fine) > 2.7);
    }
  }
}

TEST_CASE("several samples are right for rates that change linearly, and uneven ones too", "[attitude]") {
  const PhiBench fine("second", false);
  for (const int samples : {2, 3, 4}) {
    const auto bench = bench_with<PhiBench>(chosen(samples), "second", false);
    const auto single = bench_with<PhiBench>(chosen(samples, "coning", "float"), "second", false);
    for (const Flight& flight : flights) {
      INFO(samples << " samples, " << flight.name);
      const double h = 0.02;
      const PortStates ports = bench.ports(flight);
      Samples exact(flight), even(flight), uneven(flight);
      constexpr int many = 400;
      for (int i = 0; i < many; ++i) exact.whole(i * h / many, (i + 1) * h / many);
      double t = 0;
      for (int i = 0; i < samples; ++i) {
        even.whole(i * h / samples, (i + 1) * h / samples);
        const double next = i + 1 == samples ? h : t + h / samples * (i % 2 == 0 ? 0.6 : 1.3);
        uneven.whole(t, next);
        t = next;
      }
      const auto fresh = bench.check().fresh_memory();
      const auto truth = walk(fine, ports, exact.steps(), memory_before(fine, flight, h / many)).ports;
      CHECK(distance(bench, walk(bench, ports, {even.step()}, fresh).ports, truth) < 2e-6);
      CHECK(distance(bench, walk(bench, ports, {uneven.step()}, fresh).ports, truth) < 2e-6);
      // Had the uneven ones passed for even, the coning and sculling terms would be off.
      std::vector<InputSample> mistaken;
      const Step step = uneven.step();
      for (const InputSample& sample : step.samples) mistaken.push_back(sample);
      for (InputSample& sample : mistaken) sample.dt = h / samples;
      Step even_step = step;
      even_step.samples = mistaken;
      CHECK(distance(bench, walk(bench, ports, {even_step}, fresh).ports, truth) > 1e-5);
      const auto in_float = walk(single, ports, {even.step()}, fresh).ports;
      Vector3d phi;
      bench.attitude.minus(in_float[2].x, truth[2].x, phi);
      CHECK(phi.norm() < 1e-6);
      CHECK(phi.norm() > 1e-9);
    }
  }
}

TEST_CASE("attitude alone: noise, rest, memory", "[attitude]") {
  const AttitudeKind block;
  const auto model = bind<AttitudeOnly>({{{"gyro_noise", {0.03, 0.02, 0.01}}}, {{"attitude", &block}}, {}});
  const ProcessCheck check(*model, AttitudeOnly::spec());
  for (const Flight& flight : flights) {
    const PortStates ports{{&block, numbers(strapdown::quaternion_from_euler(flight.roll_pitch_yaw)), 1e-2, 4e-16}};
    Samples whole(flight), nothing(flight), parts(flight);
    for (int i = 0; i < 100; ++i) parts.part(i * 1e-4, (i + 1) * 1e-4, 0, 0.01);
    const auto memory = check.fresh_memory();
    const Step step = whole.whole(0, 0.01).step();
    REQUIRE_NO_COMPLAINTS(check.transition(ports, step, memory, {1e-9, 1e-9}));
    REQUIRE_NO_COMPLAINTS(check.noise(ports, step, parts.steps(), memory, 0.02, 1e-9));
    REQUIRE_NO_COMPLAINTS(check.zero_step(ports, nothing.whole(0, 0).step(), memory));
    Complaints out;
    // Turned by −ω about the body's axes: the sign, against the definition of the kind.
    const auto moved = check.propagate(ports, step, memory, out);
    Vector3d phi;
    block.minus(moved.x_plus[0], ports[0].x, phi);
    const Eigen::Matrix3d C = strapdown::dcm_from_quaternion(vector_at<4>(ports[0].x.data()));
    CHECK((phi - C * vector_at<3>(step.samples[0].fields)).norm() < 1e-4 * phi.norm());
  }
}

}  // namespace attitude_choice_test
