// SPDX-License-Identifier: Apache-2.0
// Plugin core: vectors, linear processes, the linear measurement.
#include <cmath>

#include "../../plugins/core/gauss_markov.hpp"
#include "../../plugins/core/integrated.hpp"
#include "../../plugins/core/linear.hpp"
#include "../../plugins/core/linear_measurement.hpp"
#include "../../plugins/core/random_constant.hpp"
#include "../../plugins/core/random_walk.hpp"
#include "../../plugins/core/vector_block.hpp"

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "support/navigation_kinds.hpp"

namespace core_test {

using namespace binnacle;
using namespace binnacle::core;
using namespace binnacle::test;
using Json = nlohmann::json;

namespace {

Step step_of(double dt) {
  Step step;
  step.t0 = 0;
  step.t1 = nanoseconds(dt);
  step.dt = dt;
  return step;
}

std::vector<Step> parts_of(double dt, int count) {
  return std::vector<Step>(static_cast<std::size_t>(count), step_of(dt / count));
}

/// What every closed form must hold, and its continuous form with it.
void check_closed_form(const ProcessModel& model, const ComponentSpec& spec, const PortStates& ports) {
  const ProcessCheck check(model, spec);
  for (const double dt : {1e-3, 0.7, 900.0}) {
    REQUIRE_NO_COMPLAINTS(check.transition(ports, step_of(dt), {}, {1e-9}));
    REQUIRE_NO_COMPLAINTS(check.noise(ports, step_of(dt), parts_of(dt, 7), {}, 1e-9));
    REQUIRE(model.declaration().has_continuous_form);
    Complaints out;
    const auto [F, GQG] = check.continuous(ports, out);
    const auto [Phi, Q] = van_loan(F, GQG, dt);
    const Propagation p = check.propagate(ports, step_of(dt), {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    const std::pair<int, int> own{0, 0};
    REQUIRE((p.transition.at(own) - Phi).isZero(1e-12));
    REQUIRE((p.noise.at(own) - Q).isZero(1e-11 * (Q.cwiseAbs().maxCoeff() + 1e-30)));
  }
  REQUIRE_NO_COMPLAINTS(check.zero_step(ports, step_of(0), {}));
}

}  // namespace

TEST_CASE("vector block: kind, names and laws", "[core]") {
  const auto bias = bind<VectorBlock>({{{"size", 3}, {"unit", "rad/s"}, {"display", "deg/h"}}, {}, {}});
  const StateBlockDeclaration& declared = bias->declaration();
  REQUIRE(declared.kind == "vector:3:rad/s");
  REQUIRE(declared.dof() == 3);
  REQUIRE(declared.error[2].name == "z");
  REQUIRE(declared.error[2].unit == "rad/s");
  REQUIRE(declared.outputs[0].name == "x");
  REQUIRE(declared.outputs[0].display_unit == "deg/h");
  REQUIRE(declared.error_display_unit == "deg/h");
  REQUIRE(declared.norms.size() == 1);
  REQUIRE(declared.norms[0].components == std::vector<int>{0, 1, 2});
  REQUIRE_NO_COMPLAINTS(check_block(*bias, {1.0, -2.0, 3e-4}, 10.0, 1e-14));

  const auto one = bind<VectorBlock>({{{"size", 1}}, {}, {}});
  REQUIRE(one->declaration().kind == "vector:1:1");
  REQUIRE(one->declaration().error[0].name == "x");
  REQUIRE(one->declaration().norms.empty());
  const auto many = bind<VectorBlock>({{{"size", 11}}, {}, {}});
  REQUIRE(many->declaration().error[10].name == "x10");
  REQUIRE_NO_COMPLAINTS(check_block(*many, std::vector<double>(11, -3.5), 1.0, 1e-14));
  const auto named = bind<VectorBlock>({{{"size", 2}, {"components", {"bias", "drift"}}}, {}, {}});
  REQUIRE(named->declaration().outputs[1].name == "drift");

  double x[3] = {1, 2, 3};
  const double bad[3] = {0, std::nan(""), 0};
  REQUIRE(bias->write(bad, x).refusal == Refusal::invalid);
  REQUIRE(x[0] == 1);
}

TEST_CASE("vector block: what it refuses", "[core]") {
  const auto with = [](Json components) { return Setup{{{"size", 2}, {"components", std::move(components)}}, {}, {}}; };
  REQUIRE_THROWS_AS(bind<VectorBlock>(with({"a"})), ComponentError);
  REQUIRE_THROWS_AS(bind<VectorBlock>(with({"a", "a"})), ComponentError);
  REQUIRE_THROWS_AS(bind<VectorBlock>(with({"a", ""})), ComponentError);
  REQUIRE_THROWS_AS(bind<VectorBlock>(with({"a", "norm"})), ComponentError);
  REQUIRE_THROWS_AS(bind<VectorBlock>(with({"a", "b.c"})), ComponentError);
}

TEST_CASE("random constant: any kind stays as it is", "[core]") {
  const AttitudeKind attitude;
  const auto model = bind<RandomConstant>({{}, {{"x", &attitude}}, {}});
  REQUIRE(model->declaration().transition.empty());
  REQUIRE(model->declaration().noise.empty());
  REQUIRE_FALSE(model->declaration().has_continuous_form);
  const ProcessCheck check(*model, RandomConstant::spec());
  REQUIRE_NO_COMPLAINTS(check.zero_step({{&attitude, {0.5, -0.5, 0.5, 0.5}}}, step_of(100), {}));

  const AdditiveKind vector(2, "m/s");
  const auto constant = bind<RandomConstant>({{}, {{"x", &vector}}, {}});
  check_closed_form(*constant, RandomConstant::spec(), {{&vector, {4.0, -1.0}}});
}

TEST_CASE("random walk: closed and continuous form", "[core]") {
  const AdditiveKind vector(3, "rad/s");
  const auto model = bind<RandomWalk>({{{"q", {0.1, 2.0, 0.0}}}, {{"x", &vector}}, {}});
  check_closed_form(*model, RandomWalk::spec(), {{&vector, {1.0, -2.0, 0.5}}});
  Complaints out;
  const auto p = ProcessCheck(*model, RandomWalk::spec()).propagate({{&vector, {1, 1, 1}}}, step_of(4), {}, out);
  REQUIRE(std::abs(p.noise.at({0, 0})(1, 1) - 16.0) < 1e-12);
  REQUIRE(model->declaration().transition.empty());
  const auto broadcast = bind<RandomWalk>({{{"q", 3.0}}, {{"x", &vector}}, {}});
  const auto q = ProcessCheck(*broadcast, RandomWalk::spec()).propagate({{&vector, {1, 1, 1}}}, step_of(1), {}, out);
  REQUIRE(std::abs(q.noise.at({0, 0})(2, 2) - 9.0) < 1e-12);
}

TEST_CASE("Gauss-Markov: closed and continuous form, steady state", "[core]") {
  const AdditiveKind vector(3, "rad/s");
  const auto model =
      bind<GaussMarkov>({{{"tau", {0.5, 300.0, 3600.0}}, {"sigma", {1.0, 0.02, 3e-6}}}, {{"x", &vector}}, {}});
  const PortStates ports{{&vector, {1.0, -0.1, 2e-6}}};
  check_closed_form(*model, GaussMarkov::spec(), ports);
  const ProcessCheck check(*model, GaussMarkov::spec());
  Complaints out;
  const Propagation e_fold = check.propagate(ports, step_of(300), {}, out);
  REQUIRE(std::abs(e_fold.x_plus[0][1] + 0.1 * std::exp(-1.0)) < 1e-15);
  const Propagation late = check.propagate(ports, step_of(1e6), {}, out);
  REQUIRE(std::abs(late.noise.at({0, 0})(1, 1) - 4e-4) < 1e-15);
  // A step so short that 1 − exp(−2 dt/τ) would lose eleven digits: Qd is 2σ²dt/τ.
  const Propagation tiny = check.propagate(ports, step_of(1e-8), {}, out);
  REQUIRE(std::abs(tiny.noise.at({0, 0})(2, 2) / (2 * 9e-12 * 1e-8 / 3600) - 1) < 1e-9);
}

TEST_CASE("integrated: with the process of its rate it has the cross terms of Qd", "[core]") {
  const AdditiveKind angle(1, "rad"), drift(1, "rad/s");
  const auto integral = bind<Integrated>({{{"q", 0.3}}, {{"x", &angle}, {"rate", &drift}}, {}});
  const auto process = bind<GaussMarkov>({{{"tau", 2.0}, {"sigma", 0.5}}, {{"x", &drift}}, {}});
  REQUIRE_FALSE(integral->declaration().has_closed_form);
  ProcessOutput nowhere;
  REQUIRE(integral->propagate({step_of(1), {}, {}, {}, {}}, nowhere).refusal == Refusal::failed);
  Complaints out;
  const auto [F1, Q1] = ProcessCheck(*integral, Integrated::spec()).continuous({{&angle, {1.0}}, {&drift, {2.0}}}, out);
  const auto [F2, Q2] = ProcessCheck(*process, GaussMarkov::spec()).continuous({{&drift, {2.0}}}, out);
  REQUIRE_NO_COMPLAINTS(out);
  Eigen::MatrixXd F = F1, Q = Q1;
  F(1, 1) += F2(0, 0);
  Q(1, 1) += Q2(0, 0);
  const double dt = 1.5, tau = 2.0, variance = 0.25, q2 = 0.09;
  const auto [Phi, Qd] = van_loan(F, Q, dt);
  const double e = std::exp(-dt / tau);
  REQUIRE(std::abs(Phi(0, 1) - tau * (1 - e)) < 1e-12);
  REQUIRE(std::abs(Phi(1, 1) - e) < 1e-12);
  REQUIRE(std::abs(Phi(1, 0)) < 1e-15);
  // ∫ (2σ²/τ) τ(1 − e^{−s/τ}) e^{−s/τ} ds = σ² τ (1 − e)²
  REQUIRE(std::abs(Qd(0, 1) - variance * tau * (1 - e) * (1 - e)) < 1e-12);
  REQUIRE(std::abs(Qd(1, 1) - variance * (1 - e * e)) < 1e-12);
  const double position = 2 * variance * tau * (dt - 2 * tau * (1 - e) + tau / 2 * (1 - e * e));
  REQUIRE(std::abs(Qd(0, 0) - position - q2 * dt) < 1e-12);

  const AdditiveKind wide(2, "rad/s");
  REQUIRE_THROWS_AS(bind<Integrated>({{}, {{"x", &angle}, {"rate", &wide}}, {}}), ComponentError);
}

TEST_CASE("linear: the ship's roll of paper 004 has its stated steady state", "[core]") {
  const AdditiveKind roll(2, "1");
  const double zeta = 0.2235, omega = 1.98, sigma = 0.825;
  const double q = std::sqrt(4 * zeta * omega * omega * omega * sigma * sigma);
  const auto model = bind<Linear>(
      {{{"F", {{0.0, 1.0}, {-omega * omega, -2 * zeta * omega}}}, {"G", {{0.0}, {1.0}}}, {"q", Json::array({q})}},
       {{"x", &roll}},
       {}});
  Complaints out;
  const auto [F, GQG] = ProcessCheck(*model, Linear::spec()).continuous({{&roll, {0.1, 0.2}}}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE(F(1, 0) == -omega * omega);
  REQUIRE(GQG(0, 0) == 0.0);
  const auto [Phi, Qd] = van_loan(F, GQG, 60.0);
  REQUIRE(Phi.cwiseAbs().maxCoeff() < 1e-9);
  REQUIRE(std::abs(Qd(0, 0) - sigma * sigma) < 1e-6);
  REQUIRE(std::abs(Qd(1, 1) - sigma * sigma * omega * omega) < 1e-6);
}

TEST_CASE("linear: what it refuses, and its noise by default", "[core]") {
  const AdditiveKind block(2, "m");
  const auto with = [&](Json parameters) { return Setup{std::move(parameters), {{"x", &block}}, {}}; };
  const Json F = {{0, 1}, {0, 0}};
  REQUIRE_THROWS_AS(bind<Linear>(with({{"F", {{0.0, 1.0, 2.0}, {0, 0, 0}}}})), ComponentError);
  REQUIRE_THROWS_AS(bind<Linear>(with({{"F", F}, {"G", {{1.0}, {0.0}}}})), ComponentError);
  REQUIRE_THROWS_AS(bind<Linear>(with({{"F", F}, {"G", {{1.0}, {0.0}, {0.0}}}, {"q", Json::array({1.0})}})),
                    ComponentError);
  REQUIRE_THROWS_AS(bind<Linear>(with({{"F", F}, {"G", {{1.0}, {0.0}}}, {"q", {1.0, 2.0}}})), ComponentError);
  REQUIRE(bind<Linear>(with({{"F", F}}))->declaration().noise.empty());
  const auto model = bind<Linear>(with({{"F", F}, {"q", {2.0, 3.0}}}));
  Complaints out;
  const auto [dynamics, noise] = ProcessCheck(*model, Linear::spec()).continuous({{&block, {0, 0}}}, out);
  REQUIRE(noise(0, 0) == 4.0);
  REQUIRE(noise(1, 1) == 9.0);
  REQUIRE(noise(0, 1) == 0.0);
  REQUIRE(dynamics(0, 1) == 1.0);
  REQUIRE(dynamics(1, 0) == 0.0);
}

TEST_CASE("linear measurement: H, residual, bias, refusals", "[core]") {
  const AdditiveKind block(3, "rad"), bias(2, "rad");
  const std::vector<std::string> no_more_than_two{"z2", "z3", "z4", "z5", "z6", "z7"};
  const Json H = {{1.0, 0.0, -2.0}, {0.5, 3.0, 0.0}};
  const std::vector<double> z{0.4, -0.2, 0, 0, 0, 0, 0, 0};
  SampleView sample;
  sample.t = 0;
  sample.fields = z.data();

  const auto model =
      bind<LinearMeasurement>({{{"H", H}, {"sigma", {0.1, 0.2}}}, {{"x", &block}, {"bias", &bias}}, no_more_than_two});
  const PortStates ports{{&block, {1.0, 2.0, 3.0}, 0.1, 1e-15}, {&bias, {0.01, -0.02}, 0.1, 1e-15}};
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, LinearMeasurement::spec(), sample, ports, {}, {1e-10}));
  Complaints out;
  const Measured m = linearize(*model, sample, ports, {}, out);
  REQUIRE(std::abs(m.residual[0] - (0.4 - (1.0 - 6.0) - 0.01)) < 1e-14);
  REQUIRE(std::abs(m.residual[1] - (-0.2 - 6.5 + 0.02)) < 1e-14);
  REQUIRE(std::abs(m.R(1, 1) - 0.04) < 1e-16);
  REQUIRE(model->declaration().groups[0].port == -1);
  REQUIRE(model->declaration().groups[0].unit == "rad");

  const auto direct = bind<LinearMeasurement>({{{"sigma", Json::array({0.3})}}, {{"x", &bias}}, no_more_than_two});
  REQUIRE(direct->declaration().groups[0].port == 0);
  REQUIRE_NO_COMPLAINTS(
      check_measurement(*direct, LinearMeasurement::spec(), sample, {{&bias, {0.01, -0.02}}, {}}, {}, {1e-10}));
  const std::vector<double> lost{0.4, std::nan(""), 0, 0, 0, 0, 0, 0};
  sample.fields = lost.data();
  REQUIRE(linearize(*direct, sample, {{&bias, {0, 0}}, {}}, {}, out).result.refusal == Refusal::invalid);

  const auto with = [&](Json parameters, Ports bound) {
    return Setup{std::move(parameters), std::move(bound), no_more_than_two};
  };
  REQUIRE_THROWS_AS(bind<LinearMeasurement>(with({{"sigma", Json::array({1.0})}}, {{"x", &block}})), ComponentError);
  REQUIRE_THROWS_AS(bind<LinearMeasurement>(with({{"sigma", Json::array({1.0})}, {"H", {{1.0}}}}, {{"x", &block}})),
                    ComponentError);
  REQUIRE_THROWS_AS(bind<LinearMeasurement>(with({{"sigma", {1, 2, 3}}, {"H", H}}, {{"x", &block}})), ComponentError);
  REQUIRE_THROWS_AS(bind<LinearMeasurement>(
                        with({{"sigma", Json::array({1})}, {"H", H}}, {{"x", &block}, {"bias", &block}})),
                    ComponentError);
}

}  // namespace core_test
