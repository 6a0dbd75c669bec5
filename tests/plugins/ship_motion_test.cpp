// SPDX-License-Identifier: Apache-2.0
// Plugin ship_motion: shaping filters, the rate gyro as input, the gyros as measurements.
#include <cmath>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"

#include "../../plugins/ship_motion/gyro.hpp"
#include "../../plugins/ship_motion/motion.hpp"
#include "../../plugins/ship_motion/rate_integral.hpp"

namespace ship_motion_test {

using namespace binnacle;
using namespace binnacle::ship_motion;
using namespace binnacle::test;
using Json = nlohmann::json;

namespace {

const AdditiveKind angle(1, "rad"), rate(1, "rad/s"), forcing(1, "rad/s^2"), forcing_rate(1, "rad/s^3");

PortState state(const AdditiveKind& kind, double x) { return {&kind, {x}}; }

}  // namespace

TEST_CASE("ship motion of order 2: the paper's density, the stated steady state", "[ship_motion]") {
  const double w = 1.98, z = 0.2235, sigma = 0.0144;
  const auto model =
      bind<Motion>({{{"omega", {w}}, {"zeta", {z}}, {"sigma", sigma}}, {{"angle", &angle}, {"rate", &rate}}, {}});
  Complaints out;
  const auto [F, GQG] =
      ProcessCheck(*model, Motion::spec()).continuous({state(angle, 0.1), state(rate, 0.2), {}, {}}, out);
  REQUIRE_NO_COMPLAINTS(out);
  Eigen::Matrix2d wanted;
  wanted << 0, 1, -w * w, -2 * z * w;
  REQUIRE((F.topLeftCorner(2, 2) - wanted).isZero(1e-14));
  REQUIRE(std::abs(GQG(1, 1) / (4 * z * w * w * w * sigma * sigma) - 1) < 1e-12);
  REQUIRE(GQG(0, 0) == 0);
  const auto [Phi, Q] = van_loan(wanted, GQG.topLeftCorner(2, 2), 200.0);
  REQUIRE(std::abs(std::sqrt(Q(0, 0)) / sigma - 1) < 1e-9);
  REQUIRE(std::abs(std::sqrt(Q(1, 1)) / (w * sigma) - 1) < 1e-9);
}

TEST_CASE("ship motion of order 4: the stated steady state", "[ship_motion]") {
  const auto model =
      bind<Motion>({{{"omega", {0.6, 1.1}}, {"zeta", {0.1, 0.4}}, {"sigma", 0.05}},
                    {{"angle", &angle}, {"rate", &rate}, {"forcing", &forcing}, {"forcing_rate", &forcing_rate}},
                    {}});
  Complaints out;
  const auto [F, GQG] =
      ProcessCheck(*model, Motion::spec())
          .continuous({state(angle, 0.1), state(rate, 0.2), state(forcing, 0), state(forcing_rate, 0)}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE(F(1, 2) == 1);
  REQUIRE(std::abs(F(3, 2) + 1.1 * 1.1) < 1e-15);
  const auto [Phi, Q] = van_loan(F, GQG, 400.0);
  REQUIRE(std::abs(std::sqrt(Q(0, 0)) / 0.05 - 1) < 1e-8);
}

TEST_CASE("ship motion: what it refuses", "[ship_motion]") {
  const Ports two{{"angle", &angle}, {"rate", &rate}};
  const auto with = [&](Json omega, Json zeta) {
    return Setup{{{"omega", std::move(omega)}, {"zeta", std::move(zeta)}, {"sigma", 1}}, two, {}};
  };
  REQUIRE_THROWS_AS(bind<Motion>(with({1.0, 2.0}, {0.1, 0.1})), ComponentError);
  REQUIRE_THROWS_AS(bind<Motion>(with({1.0}, {0.1, 0.1})), ComponentError);
  REQUIRE_THROWS_AS(bind<Motion>(with({1.0, 2.0, 3.0}, {0.1, 0.1, 0.1})), ComponentError);
}

TEST_CASE("rate integral: turns by what the gyro reads less its drift", "[ship_motion]") {
  const auto model = bind<RateIntegral>({{{"noise", 0.02}}, {{"angle", &angle}, {"drift", &rate}}, {}});
  const double u = 0.3;
  InputSample sample;
  sample.t0 = sample.whole_t0 = 0;
  sample.t1 = sample.whole_t1 = nanoseconds(0.5);
  sample.dt = 0.5;
  sample.fields = &u;
  Step step;
  step.t0 = 0;
  step.t1 = sample.t1;
  step.dt = 0.5;
  step.samples = {&sample, 1};
  const PortStates ports{state(angle, 1.0), state(rate, 0.1)};
  const ProcessCheck check(*model, RateIntegral::spec());
  REQUIRE_NO_COMPLAINTS(check.transition(ports, step, {}, {1e-9}));
  Complaints out;
  const auto p = check.propagate(ports, step, {}, out);
  REQUIRE(std::abs(p.x_plus[0][0] - (1.0 + 0.15 - 0.05)) < 1e-15);
  REQUIRE(std::abs(p.noise.at({0, 0})(0, 0) - 0.02 * 0.02 * 0.5) < 1e-16);
}

TEST_CASE("gyros: axes that are bound, with their errors", "[ship_motion]") {
  const double z[] = {0.3, -0.2};
  SampleView sample;
  sample.t = 0;
  sample.fields = z;
  const auto both =
      bind<VerticalGyro>({{{"sigma", 0.01}}, {{"roll", &angle}, {"roll_error", &angle}, {"pitch", &angle}}, {}});
  const PortStates ports{state(angle, 0.1), state(angle, 0.05), state(angle, -0.3), {}};
  REQUIRE_NO_COMPLAINTS(check_measurement(*both, VerticalGyro::spec(), sample, ports, {}, {1e-9}));
  Complaints out;
  const Measured m = linearize(*both, sample, ports, {}, out);
  REQUIRE(std::abs(m.residual[0] - 0.15) < 1e-15);
  REQUIRE(std::abs(m.residual[1] - 0.1) < 1e-15);
  REQUIRE(std::abs(m.R(1, 1) - 1e-4) < 1e-18);
  REQUIRE(m.R(0, 1) == 0);

  const auto yaw = bind<DirectionalGyro>({{{"sigma", 0.01}}, {{"yaw", &angle}}, {"roll"}});
  REQUIRE(std::abs(linearize(*yaw, sample, {{}, {}, state(angle, 0.5), {}}, {}, out).residual[0] + 0.7) < 1e-15);
  const double lost[] = {0.3, std::nan("")};
  sample.fields = lost;
  REQUIRE(linearize(*yaw, sample, {{}, {}, state(angle, 0.5), {}}, {}, out).result.refusal == Refusal::invalid);

  REQUIRE_THROWS_AS(bind<VerticalGyro>({{{"sigma", 0.01}}, {}, {}}), ComponentError);
  REQUIRE_THROWS_AS(bind<VerticalGyro>({{{"sigma", 0.01}}, {{"roll_error", &angle}, {"pitch", &angle}}, {}}),
                    ComponentError);
  REQUIRE_THROWS_AS(bind<DirectionalGyro>({{{"sigma", 0.01}}, {{"yaw", &angle}}, {"yaw"}}), ComponentError);
}

}  // namespace ship_motion_test
