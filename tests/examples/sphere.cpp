// SPDX-License-Identifier: Apache-2.0
// The plugin's own tests: the sphere itself, the models as sphere.json composes them, and fifty runs.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include <cmath>
#include <numbers>

#include "common/example.hpp"
#include "s2.hpp"

using namespace binnacle;
using example::is_near;
using s2::Frame;
using s2::Vector2;
using s2::Vector3;

namespace {

Frame at(double x, double y, double z) { return s2::frame_at(Vector3(x, y, z).normalized()); }

/// Poles, the equator, where frame_at() jumps, on both sides of it, and anywhere; the last with axes that have moved.
const std::vector<Frame> frames{at(0, 0, 1),     at(0, 0, -1),        at(1, 0, 0),
                                at(0, -1, -0.0), at(0.6, 0.8, 1e-9),  at(0.6, 0.8, -1e-9),
                                at(-1, 1, 0.2),  at(0.3, -0.5, -0.9), s2::plus(at(0.3, -0.5, -0.9), {0.4, 1.2})};
const std::vector<Vector2> errors{{0, 0},      {1e-9, -2e-9}, {5e-5, 2e-5}, {1e-3, -3e-3},
                                  {0.02, 0.3}, {-1.5, 0.8},   {2, 1.5}};

/// ∂f/∂δ at δ = 0 by central differences, extrapolated (Richardson).
template <int Columns, class Function>
auto differences(const Function& f, double h = 1e-3) {
  Eigen::Matrix<double, decltype(f(Eigen::Matrix<double, Columns, 1>()))::RowsAtCompileTime, Columns> J;
  for (int j = 0; j < Columns; ++j) {
    const auto central = [&](double step) {
      const Eigen::Matrix<double, Columns, 1> delta = step * Eigen::Matrix<double, Columns, 1>::Unit(j);
      return ((f(delta) - f(-delta)) / (2 * step)).eval();
    };
    J.col(j) = (4 * central(h / 2) - central(h)) / 3;
  }
  return J;
}

using Process = parts::Part<ProcessModel>;
using Measurement = parts::Part<MeasurementModel>;

std::vector<double> numbers(const Frame& frame) { return {frame.data(), frame.data() + 9}; }

/// A step over samples of 0.1 s each.
class Turn {
 public:
  explicit Turn(std::vector<Vector3> rates) : rates_(std::move(rates)) {
    constexpr Time interval = 100'000'000;
    for (const Vector3& rate : rates_) {
      samples_.push_back({step_.t1, step_.t1 + interval, 0.1, step_.t1, step_.t1 + interval, rate.data()});
      step_.t1 += interval, step_.dt += 0.1;
    }
    step_.samples = samples_;
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  const Step& step() const { return step_; }

 private:
  std::vector<Vector3> rates_;
  std::vector<InputSample> samples_;
  Step step_{0, 0, 0, {}};
};

testing::Given given(const Vector3& z) {
  testing::Given given;
  given.sample.t = nanoseconds(1);
  given.sample.fields = z.data();
  given.sample.available = true;
  return given;
}

}  // namespace

TEST_CASE("the axes are orthonormal everywhere, and stay so") {
  for (const Frame& x : frames) {
    CHECK((x.transpose() * x).isIdentity(1e-14));
    for (const Vector2& delta : errors) {
      const Frame y = s2::plus(x, delta);
      CHECK((y.transpose() * y).isIdentity(1e-14));
    }
  }
}

TEST_CASE("plus and minus undo each other, along great circles") {
  for (const Frame& x : frames)
    for (const Vector2& delta : errors) {
      INFO(x << " by " << delta.transpose());
      const Vector3 from = s2::direction(x), to = s2::direction(s2::plus(x, delta));
      CHECK((s2::minus(to, x) - delta).norm() < 1e-13);
      CHECK(is_near(std::atan2(from.cross(to).norm(), from.dot(to)), delta.norm(), 0, 1e-14));
    }
}

TEST_CASE("the derivatives of plus and minus, and the reset, are those of differences") {
  for (const Frame& x : frames)
    for (const Vector2& delta : errors) {
      INFO(x << " by " << delta.transpose());
      const Frame y = s2::plus(x, delta);
      const auto moved = [&](const Vector2& e) { return s2::direction(s2::plus(x, delta + e)); };
      CHECK((differences<2>(moved) - s2::plus_jacobian(x, delta)).cwiseAbs().maxCoeff() < 1e-9);
      const auto remains = [&](const Vector2& e) { return s2::minus(moved(e), y); };
      CHECK((differences<2>(remains) - s2::reset_jacobian(delta)).cwiseAbs().maxCoeff() < 1e-9);
      const auto away = [&](const Vector2& e) { return s2::minus(s2::direction(s2::plus(y, e)), x); };
      CHECK((differences<2>(away) - s2::minus_jacobian(y, x)).cwiseAbs().maxCoeff() < 1e-7);
    }
}

TEST_CASE("the block keeps the laws, and its reset Jacobian is that of what remains") {
  const auto down = parts::block(example::composition(), "body", "down");
  for (const Frame& x : frames)
    for (const Vector2& delta : errors) {
      const testing::PortState state(down.block.get(), numbers(x));
      testing::Complaints complaints = check_laws(state, delta);
      complaints.add_all(check_readable(state));
      if (delta.norm() > 1e-4) complaints.add_all(check_reset(state, delta, 0.01, 1e-6));
      INFO(x << " by " << delta.transpose() << ":\n" << complaints.text());
      CHECK(complaints.empty());
    }
}

TEST_CASE("a vector of length 1 is a direction, and nothing else") {
  CHECK_NOTHROW(example::compose({"/filters/body/blocks/down/init/z=0.805"}));
  CHECK_THROWS(example::compose({"/filters/body/blocks/down/init/z=1.6"}));
  CHECK_THROWS(example::compose({"/filters/body/blocks/down/init/z=0", "/filters/body/blocks/down/init/y=0"}));
}

TEST_CASE("in axes that turn to the right a fixed direction goes to the left") {
  const auto process = parts::process(example::composition(), "body", "turning");
  const testing::ProcessCaller caller(*process.model, process.type->spec);
  const auto ports = example::at(process.ports, {numbers(at(1, 0, 0)), {0, 0, 0.1}}, 1e-3);
  // 0.1 s at 1.1 rad/s about z, of which 0.1 are bias: a tenth of a radian.
  const Turn turn({Vector3(0, 0, 1.1)});
  const auto turned = caller.propagate(ports, turn.step(), caller.fresh_memory());
  REQUIRE(turned.result);
  CHECK((vector_at<3>(turned.x_plus[0].data() + 6) - Vector3(std::cos(0.1), -std::sin(0.1), 0)).norm() < 1e-15);
  const double q = 0.1 * std::numbers::pi / 180;  // of sphere.json
  CHECK((turned.noise[0] / (q * q * 0.1)).isIdentity(1e-12));
}

TEST_CASE("Phi is the derivative of a step on the sphere, and the step the same without it") {
  const auto process = parts::process(example::composition(), "body", "turning");
  const testing::ProcessCaller caller(*process.model, process.type->spec);
  const Turn tumble({{0.5, -1, 2}, {3, 0.2, -0.4}, {0, 0, 0}});
  for (const Frame& x : frames) {
    const auto ports = example::at(process.ports, {numbers(x), {0.1, -0.2, 0.05}}, 1e-2);
    auto complaints = check_transition(caller, ports, tumble.step(), caller.fresh_memory(), {.relative = 1e-7});
    complaints.add_all(check_values(caller, ports, tumble.step(), caller.fresh_memory()));
    INFO(x << ":\n" << complaints.text());
    CHECK(complaints.empty());
  }
}

TEST_CASE("H is the derivative of what is seen, however far from the estimate") {
  const auto seen = parts::measurement(example::composition(), "body", "seen");
  const testing::MeasurementCaller caller(*seen.model, seen.type->spec);
  for (const Frame& x : frames)
    for (const Vector2& delta : errors) {
      if (delta.norm() > 2) continue;
      const Vector3 z = 9.8 * s2::direction(s2::plus(x, delta));  // of any length
      const auto ports = example::at(seen.ports, {numbers(x)}, 1e-3);
      const auto sighted = caller.linearize(given(z), ports, caller.fresh_memory());
      REQUIRE(sighted.result);
      CHECK(is_near(sighted.residual.norm(), delta.norm(), 0, 1e-14));
      auto complaints = check_measurement(caller, given(z), ports, caller.fresh_memory(), {.relative = 1e-6}, 1e-15);
      complaints.add_all(check_values(caller, given(z), ports, caller.fresh_memory()));
      INFO(x << " seen at " << z.transpose() << ":\n" << complaints.text());
      CHECK(complaints.empty());
      if (delta.norm() > 0.05) continue;
      // An update without noise ends where the sighting points.
      const Vector2 correction = sighted.H[0].inverse() * sighted.residual;
      CHECK((s2::direction(s2::plus(x, correction)) - z.normalized()).norm() < 1e-5);
    }
  const auto ahead = example::at(seen.ports, {numbers(at(1, 0, 0))}, 1e-3);
  const Vector3 behind(-1, 0.1, 0), nothing(0, 0, 0);
  CHECK_FALSE(caller.linearize(given(behind), ahead, caller.fresh_memory()).result);
  CHECK_FALSE(caller.linearize(given(nothing), ahead, caller.fresh_memory()).result);
}

TEST_CASE("errors of fifty runs of a tumbling body are as large as the filter believes") {
  const auto figures = example::study();
  for (const auto& [metric, dof] : std::map<std::string, double>{{"body/down/nees", 2}, {"body/gyro_bias/nees", 3}}) {
    const auto& figure = figures.at(metric);
    INFO(metric << " " << figure.mean << " in " << figure.runs << " runs");
    CHECK(figure.runs == 50);
    CHECK(std::abs(figure.mean - dof) < 2.58 * std::sqrt(2 * dof / figure.runs));  // 99 %
  }
  CHECK(std::abs(figures.at("body/seen/nis").mean - 2) < 0.05);
  CHECK(figures.at("body/gyro_bias.norm/final").mean < 0.2);  // deg/s, of 0.5 at the start
}
