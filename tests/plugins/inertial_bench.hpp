// SPDX-License-Identifier: Apache-2.0
// Flights, samples and a bench for inertial process models, whatever their error model.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace binnacle::test {

inline constexpr double degree = M_PI / 180;

inline std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

struct Flight {
  const char* name;
  Eigen::Vector3d lla, v_n, roll_pitch_yaw;
  Eigen::Vector3d omega, f;            // body, at the middle of the step
  Eigen::Vector3d omega_rate, f_rate;  // their change per second
};
inline const Flight flights[] = {
    {"a car",
     {0.65, 2.2, 60},
     {8, -5, 0.1},
     {0.02, -0.03, 2.5},
     {0.05, -0.1, 0.6},
     {0.5, 3, -9.8},
     {1, 2, -1},
     {3, 4, 5}},
    {"a fast aircraft",
     {0.8, -1.3, 11000},
     {180, 170, -4},
     {0.9, 0.2, 0.75},
     {0.8, 0.3, -0.2},
     {2, -1, -14},
     {1, -1, 2},
     {9, 5, 7}},
    {"the southern hemisphere",
     {-0.59, 2.6, 400},
     {-12, 30, 1},
     {-0.2, 0.1, -1.9},
     {-0.3, 0.2, 0.1},
     {-2, 1, -9},
     {1, 1, 1},
     {4, 3, 2}},
    {"a high latitude",
     {1.4, -3.1, 5},
     {30, 40, 0},
     {0.1, 0.02, 3.1},
     {0.1, 0.2, -0.5},
     {0.2, 0.3, -9.83},
     {-1, 1, 0},
     {3, 3, 3}},
    {"upside down",
     {0.1, 0.3, 3000},
     {100, -90, 20},
     {3.0, -0.6, -2.7},
     {-1.5, 0.7, 0.4},
     {1, -2, 8},
     {2, -2, 1},
     {8, -6, 4}},
};

/// The process under test on plain blocks of its kinds, everything plugged in or nothing.
template <class Process>
struct InertialBench {
  PositionKind position;
  AdditiveKind velocity{"velocity.ned", 3, "m/s"};
  AttitudeKind attitude;
  AdditiveKind gyro_bias{3, "rad/s"}, accel_bias{3, "m/s^2"}, scale{3, "1"};
  std::unique_ptr<Process> model;
  bool has_sensor_errors;

  explicit InertialBench(const std::string& order = "second", bool with_sensor_errors = true,
                         const nlohmann::json& gyro_noise = {0.03, 0.02, 0.01},
                         const nlohmann::json& accel_noise = {0.1, 0.2, 0.3},
                         const nlohmann::json& more = nlohmann::json::object(),
                         const std::vector<std::string>& frozen = {})
      : has_sensor_errors(with_sensor_errors) {
    Setup setup{{{"gyro_noise", gyro_noise}, {"accel_noise", accel_noise}, {"order", order}},
                {{"position", &position}, {"velocity", &velocity}, {"attitude", &attitude}},
                {},
                more.value(nlohmann::json::json_pointer("/attitude/samples"), 1),
                {},
                frozen};
    setup.parameters.update(more);
    if (with_sensor_errors)
      setup.ports.insert(
          {{"gyro_bias", &gyro_bias}, {"accel_bias", &accel_bias}, {"gyro_scale", &scale}, {"accel_scale", &scale}});
    model = bind<Process>(setup);
  }
  ProcessCheck check() const { return {*model, Process::spec()}; }

  PortStates ports(const Flight& flight) const {
    PortStates all{{&position, numbers(flight.lla), 100.0, 4e-9},
                   {&velocity, numbers(flight.v_n), 1.0, 1e-13},
                   {&attitude, numbers(strapdown::quaternion_from_euler(flight.roll_pitch_yaw)), 1e-2, 4e-16},
                   {},
                   {},
                   {},
                   {}};
    if (has_sensor_errors) {
      all[3] = {&gyro_bias, {0.01, -0.02, 0.03}, 1e-2, 1e-16};
      all[4] = {&accel_bias, {0.1, 0.2, -0.3}, 1.0, 1e-16};
      all[5] = {&scale, {0.01, -0.01, 0.02}, 1e-2, 1e-16};
      all[6] = {&scale, {-0.01, 0.03, 0.02}, 1e-2, 1e-16};
    }
    return all;
  }
};

/// Samples of a flight whose rates change linearly, cut wherever a test likes. Time 0 is the middle of interest.
class Samples {
 public:
  explicit Samples(const Flight& flight) : flight_(flight) {}

  /// A whole sample from t0 to t1 [s].
  Samples& whole(double t0, double t1) { return part(t0, t1, t0, t1); }
  /// Of the sample [whole_t0, whole_t1] the fragment from t0 to t1, cut proportionally.
  Samples& part(double t0, double t1, double whole_t0, double whole_t1) {
    const double middle = 0.5 * (whole_t0 + whole_t1), dt = t1 - t0;
    std::array<double, 6> fields;
    vector_at<3>(fields.data()) = (flight_.omega + middle * flight_.omega_rate) * dt;
    vector_at<3>(fields.data() + 3) = (flight_.f + middle * flight_.f_rate) * dt;
    fields_.push_back(fields);
    InputSample sample;
    sample.t0 = nanoseconds(t0), sample.t1 = nanoseconds(t1), sample.dt = dt;
    sample.whole_t0 = nanoseconds(whole_t0), sample.whole_t1 = nanoseconds(whole_t1);
    samples_.push_back(sample);
    return *this;
  }
  /// Whether they bridge a hole.
  void bridge(bool bridges) {
    for (InputSample& sample : samples_) sample.bridges = bridges;
  }
  /// One step of all of them. Valid as long as this object.
  Step step() { return step(0, samples_.size()); }
  /// One step each.
  std::vector<Step> steps() {
    std::vector<Step> all;
    for (std::size_t i = 0; i < samples_.size(); ++i) all.push_back(step(i, 1));
    return all;
  }

 private:
  Step step(std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < samples_.size(); ++i) samples_[i].fields = fields_[i].data();
    Step step;
    step.samples = std::span<const InputSample>(samples_).subspan(first, count);
    step.t0 = step.samples.front().t0, step.t1 = step.samples.back().t1;
    for (const InputSample& sample : step.samples) step.dt += sample.dt;
    step.bridges = step.samples.front().bridges;
    return step;
  }

  const Flight& flight_;
  std::vector<std::array<double, 6>> fields_;
  std::vector<InputSample> samples_;
};

/// What the model remembers when the step at [0, dt] begins: one sample lies behind it.
template <class Bench>
std::vector<std::byte> memory_before(const Bench& bench, const Flight& flight, double dt) {
  Complaints out;
  Samples earlier(flight);
  const auto check = bench.check();
  return check.propagate(bench.ports(flight), earlier.whole(-dt, 0).step(), check.fresh_memory(), out).memory;
}

struct Walked {
  PortStates ports;
  std::vector<std::byte> memory;
};

template <class Bench>
Walked walk(const Bench& bench, PortStates ports, const std::vector<Step>& steps, std::vector<std::byte> memory) {
  for (const Step& step : steps) {
    Complaints out;
    Propagation p = bench.check().propagate(ports, step, memory, out);
    REQUIRE_NO_COMPLAINTS(out);
    for (std::size_t i = 0; i < 3; ++i) ports[i].x = p.x_plus[i];
    memory = p.memory;
  }
  return {ports, memory};
}

/// The greatest difference of two navigation states, in m, m/s and rad alike.
template <class Bench>
double distance(const Bench& bench, const PortStates& a, const PortStates& b) {
  Eigen::Vector3d p, v, phi;
  bench.position.minus(a[0].x, b[0].x, p);
  bench.velocity.minus(a[1].x, b[1].x, v);
  bench.attitude.minus(a[2].x, b[2].x, phi);
  return std::max({p.norm(), v.norm(), phi.norm()});
}

/// Of a position that is frozen nobody reads a block; all others, and the state, are the same to the bit as with it.
template <class Process>
void check_frozen_position(const nlohmann::json& more = nlohmann::json::object()) {
  for (const bool with_sensor_errors : {false, true})
    for (const std::size_t count : {1U, 3U}) {
      const nlohmann::json noise{0.03, 0.02, 0.01};
      const InertialBench<Process> whole("second", with_sensor_errors, noise, noise, more);
      const InertialBench<Process> frozen("second", with_sensor_errors, noise, noise, more, {"position"});
      Samples samples(flights[1]);
      for (std::size_t i = 0; i < count; ++i)
        samples.whole(0.01 * static_cast<double>(i), 0.01 * static_cast<double>(i + 1));
      const auto propagated = [&](const InertialBench<Process>& bench) {
        return testing::ProcessCaller(*bench.model, Process::spec())
            .propagate(bench.ports(flights[1]), samples.step(), memory_before(whole, flights[1], 0.01));
      };
      const testing::Propagated a = propagated(whole), b = propagated(frozen);
      REQUIRE(a.x_plus == b.x_plus);
      const auto same = [](const std::vector<Coupling>& couplings, const auto& these, const auto& those) {
        int seen = 0;
        for (std::size_t i = 0; i < couplings.size(); ++i) {
          if (couplings[i].to == 0 || couplings[i].from == 0) continue;
          INFO("block " << couplings[i].to << ", " << couplings[i].from);
          CHECK(these[i] == those[i]);
          ++seen;
        }
        return seen;
      };
      const ProcessDeclaration& declared = whole.model->declaration();
      REQUIRE(frozen.model->declaration().transition.size() == declared.transition.size());
      REQUIRE(same(declared.transition, a.transition, b.transition) >= 3);
      REQUIRE(same(declared.noise, a.noise, b.noise) == 3);
    }
}

}  // namespace binnacle::test
