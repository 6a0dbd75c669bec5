// SPDX-License-Identifier: Apache-2.0
// The plugin's own tests: the models as battery.json composes them, against differences and the physics.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include <cmath>

#include "common/example.hpp"
#include "ocv_curve.hpp"

using namespace binnacle;
using example::is_near;

namespace {

/// A current [A] for a time [s].
struct Load {
  double current, dt;
};

using Process = parts::Part<ProcessModel>;
using Measurement = parts::Part<MeasurementModel>;

/// A step over several samples.
class Drive {
 public:
  explicit Drive(std::vector<Load> loads) : loads_(std::move(loads)) {
    for (const Load& load : loads_) {
      const Time end = step_.t1 + nanoseconds(load.dt);
      samples_.push_back({step_.t1, end, load.dt, step_.t1, end, &load.current});
      step_.t1 = end, step_.dt += load.dt;
    }
    step_.samples = samples_;
  }
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;
  const Step& step() const { return step_; }

 private:
  std::vector<Load> loads_;
  std::vector<InputSample> samples_;
  Step step_{0, 0, 0, {}};
};

struct Moved {
  Eigen::Vector2d x;  // charge, RC voltage [V]
  Eigen::Matrix2d Q;
};

Moved propagate(const Process& process, const Eigen::Vector2d& x, const std::vector<Load>& loads) {
  const Drive drive(loads);
  const testing::ProcessCaller caller(*process.model, process.type->spec);
  const auto ports = example::at(process.ports, {{x[0]}, {x[1]}}, 1e-3);
  const auto moved = caller.propagate(ports, drive.step(), caller.fresh_memory());
  REQUIRE(moved.result);
  REQUIRE(moved.damage.empty());
  return {{moved.x_plus[0][0], moved.x_plus[1][0]}, caller.Q(ports, moved)};
}

/// What is measured: a voltage [V] while a current [A] flows.
struct Seen {
  double voltage, current;

  testing::Given given() const {
    testing::Given given;
    given.sample.t = nanoseconds(1);
    given.sample.fields = &voltage;
    given.sample.available = true;
    given.u = {nanoseconds(1), &current};
    return given;
  }
};

/// z − h(x): charge, RC voltage [V].
double residual(const Measurement& measurement, const Seen& seen, double soc, double rc) {
  const testing::MeasurementCaller caller(*measurement.model, measurement.type->spec);
  const auto measured =
      caller.linearize(seen.given(), example::at(measurement.ports, {{soc}, {rc}}, 1e-3), caller.fresh_memory());
  REQUIRE(measured.result);
  return measured.residual[0];
}

const std::vector<Load> discharged{{3, 1}, {6, 0.5}}, charged{{-3, 1}, {-2, 2}};

}  // namespace

TEST_CASE("the open-circuit voltage goes through its points, rises, and its slope is its derivative") {
  const Eigen::VectorXd soc{{0, 0.1, 0.2, 0.5, 1}}, volts{{3, 3.4, 3.41, 3.9, 4.2}};
  const OcvCurve curve(soc, volts);
  for (int i = 0; i < 5; ++i) CHECK(is_near(curve.at(soc[i]).volts, volts[i], 1e-14));
  const double h = 1e-6;
  for (double s = -0.105; s < 1.1; s += 0.01) {
    INFO(s);
    CHECK(curve.at(s).slope > 0);
    CHECK(is_near((curve.at(s + h).volts - curve.at(s - h).volts) / (2 * h), curve.at(s).slope, 1e-6));
  }
  CHECK_THROWS_AS(OcvCurve(soc, Eigen::VectorXd(-volts)), ComponentError);
  CHECK_THROWS_AS(OcvCurve(soc, volts.head(3)), ComponentError);
}

TEST_CASE("a step is the solution of the differential equations") {
  const auto process = parts::process(example::composition(), "cell", "cell");
  const double Q = 2.5 * 3600, R1 = 0.015, C1 = 2000, efficiency = 0.99;  // of battery.json
  for (const auto& loads : {discharged, charged}) {
    const Eigen::Vector2d x(0.6, 0.02);
    Eigen::Vector2d wanted = x;
    for (const Load& load : loads)
      for (int i = 0; i < 100000; ++i) {
        const double dt = load.dt / 100000, I = load.current;
        wanted[0] -= (I < 0 ? efficiency : 1) * I * dt / Q;
        wanted[1] += (I - wanted[1] / R1) / C1 * dt;
      }
    const Moved moved = propagate(process, x, loads);
    CHECK((moved.x - wanted).cwiseAbs().maxCoeff() < 1e-7);
    CHECK((moved.x[0] < x[0]) == (loads.front().current > 0));
  }
}

TEST_CASE("Phi is the derivative of a step, and the step the same without it") {
  const auto process = parts::process(example::composition(), "cell", "cell");
  const testing::ProcessCaller caller(*process.model, process.type->spec);
  const auto ports = example::at(process.ports, {{0.6}, {0.02}}, 1e-3);
  for (const auto& loads : {discharged, charged}) {
    const Drive drive(loads);
    auto complaints = check_transition(caller, ports, drive.step(), caller.fresh_memory(), {.relative = 1e-9});
    complaints.add_all(check_values(caller, ports, drive.step(), caller.fresh_memory()));
    INFO(complaints.text());
    CHECK(complaints.empty());
  }
}

// The noise of the current is a current: each short piece of it moves charge and RC voltage by as much as a step shows.
TEST_CASE("Qd is what white noise of the current does to charge and RC voltage together") {
  const auto process = parts::process(example::composition(), "cell", "cell");
  const double q = 0.1;  // A/√Hz, of battery.json
  for (const double current : {3.0, -3.0}) {
    constexpr int pieces = 400;
    const double dt = 40.0 / pieces;  // of the order of R1 C1 = 30 s
    const std::vector<Load> loads(pieces, {current, dt});
    Eigen::Matrix2d wanted = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < pieces; ++i) {
      auto more = loads, less = loads;
      more[i].current += 0.5, less[i].current -= 0.5;
      const Eigen::Vector2d g = propagate(process, {0.6, 0}, more).x - propagate(process, {0.6, 0}, less).x;
      wanted += q * q / dt * g * g.transpose();  // the mean of white noise over dt has the variance q²/dt
    }
    const Eigen::Matrix2d Q = propagate(process, {0.6, 0}, loads).Q;
    INFO("wanted\n" << wanted << "\nis\n" << Q);
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) CHECK(is_near(Q(i, j), wanted(i, j), 1e-4));
  }
}

TEST_CASE("H is the derivative of what the terminals show, and that the same without it") {
  const auto composition =
      example::compose({R"(/filters/cell/blocks/aging={"type": "vector", "size": 1, "unit": "V/A", "sigma": "5 mV/A"})",
                        R"(/filters/cell/process/aging={"type": "random_constant", "blocks": {"x": "aging"}})",
                        R"(/filters/cell/measurements/voltage/blocks/r0_error="aging")"});
  const auto measurement = parts::measurement(*composition, "cell", "voltage");
  const testing::MeasurementCaller caller(*measurement.model, measurement.type->spec);
  for (const double current : {4.0, -2.0})
    for (const double soc : {0.03, 0.45, 0.83}) {
      const Seen seen{3.7, current};
      const auto ports = example::at(measurement.ports, {{soc}, {0.03}, {0.002}}, 1e-4);
      auto complaints = check_measurement(caller, seen.given(), ports, caller.fresh_memory(), {.relative = 1e-6});
      complaints.add_all(check_values(caller, seen.given(), ports, caller.fresh_memory()));
      INFO(complaints.text());
      CHECK(complaints.empty());
      const auto measured = caller.linearize(seen.given(), ports, caller.fresh_memory());
      CHECK(measured.H[0](0, 0) > 0);  // a fuller cell shows more
      CHECK(is_near(measured.R(0, 0), 0.005 * 0.005 + 0.02 * 0.02 * 0.1 * 0.1, 1e-9));
    }
}

TEST_CASE("the voltage under load is Kirchhoff's") {
  const auto measurement = parts::measurement(example::composition(), "cell", "voltage");
  // At 60 % the curve of battery.json shows 3.8 V: 3.8 − 0.03 − 0.02 · 5.
  CHECK(std::abs(residual(measurement, {3.67, 5}, 0.6, 0.03)) < 1e-12);
  CHECK(is_near(residual(measurement, {3.70, 5}, 0.6, 0.03), 0.03, 1e-9));
}

TEST_CASE("errors of fifty runs are as large as the filter believes") {
  const auto figures = example::study();
  for (const auto& [metric, dof] : std::map<std::string, double>{{"cell/soc/nees", 1}, {"cell/rc/nees", 1}}) {
    const auto& figure = figures.at(metric);
    INFO(metric << " " << figure.mean << " in " << figure.runs << " runs");
    CHECK(figure.runs == 50);
    CHECK(std::abs(figure.mean - dof) < 2.58 * std::sqrt(2 * dof / figure.runs));  // 99 %
  }
  CHECK(std::abs(figures.at("cell/voltage/nis").mean - 1) < 0.02);
  CHECK(figures.at("cell/soc.charge/rms").mean < 1.0);  // %, of 10 % at the start
}
