// SPDX-License-Identifier: Apache-2.0
// Plugin aiding, bearing: directions on all sides, Jacobians by differences, what cannot be seen.
#include "../../plugins/aiding/bearing.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "bind.hpp"
#include "catch.hpp"
#include "kind_blocks.hpp"
#include "model_check.hpp"

using namespace binnacle;
using namespace binnacle::aiding;
using namespace binnacle::test;

namespace {

SampleView sample_of(const std::vector<double>& fields) {
  SampleView sample;
  sample.t = 0;
  sample.fields = fields.data();
  return sample;
}

constexpr double degree = std::numbers::pi / 180;

}  // namespace

TEST_CASE("bearing: clockwise from north, to all sides", "[aiding]") {
  const AdditiveKind target(2, "m");
  const auto model = bind<Bearing>({{{"sigma", 0.01}}, {{"target", &target}}, {"elevation", "observer_down"}});
  REQUIRE(model->declaration().max_rows == 1);
  for (const double azimuth : {0.0, 45.0, 90.0, 179.9, -179.9, -90.0, -3.0}) {
    CAPTURE(azimuth);
    // From (100, -50), 2 km away; measured two degrees further to the right.
    const std::vector<double> x{100 + 2000 * std::cos(azimuth * degree), -50 + 2000 * std::sin(azimuth * degree)};
    const std::vector<double> z{std::remainder((azimuth + 2) * degree, 2 * std::numbers::pi), NAN, 100, -50, NAN};
    const PortStates ports{{&target, x, 10.0, 1e-8}};
    Complaints out;
    const Measured m = linearize(*model, sample_of(z), ports, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    REQUIRE(m.result);
    CHECK(std::abs(m.residual[0] - 2 * degree) < 1e-12);
    CHECK(m.R(0, 0) == 1e-4);
    // A metre to the right is 1/2000 of a radian.
    const Eigen::Vector2d right(-std::sin(azimuth * degree), std::cos(azimuth * degree));
    CHECK(std::abs((m.H[0] * right)(0) - 1.0 / 2000) < 1e-12);
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, Bearing::spec(), sample_of(z), ports, {}, {1e-6}, 1e-8));
  }
}

TEST_CASE("bearing: elevation, and an observer that is a block", "[aiding]") {
  const AdditiveKind target(3, "m"), observer(3, "m");
  const auto model = bind<Bearing>({{{"sigma", 0.01}, {"elevation_sigma", 0.02}},
                                    {{"target", &target}, {"observer", &observer}},
                                    {"observer_north", "observer_east", "observer_down"}});
  REQUIRE(model->declaration().max_rows == 2);
  const std::vector<double> x{300, 400, -250}, from{0, 0, 250};
  const std::vector<double> z{0.9, 0.7, NAN, NAN, NAN};
  const PortStates ports{{&target, x, 10.0, 1e-8}, {&observer, from, 10.0, 1e-8}};
  Complaints out;
  const Measured m = linearize(*model, sample_of(z), ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  CHECK(std::abs(m.residual[0] - (0.9 - std::atan2(4, 3))) < 1e-14);
  CHECK(std::abs(m.residual[1] - (0.7 - std::numbers::pi / 4)) < 1e-14);
  CHECK(m.R(1, 1) == 4e-4);
  CHECK(m.H[0] == -m.H[1]);
  CHECK(m.H[0](1, 2) < 0);  // lower is less high
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, Bearing::spec(), sample_of(z), ports, {}, {1e-6}, 1e-8));
}

TEST_CASE("bearing: what has no direction is refused", "[aiding]") {
  const AdditiveKind target(2, "m");
  const auto model = bind<Bearing>({{{"sigma", 0.01}}, {{"target", &target}}, {"elevation", "observer_down"}});
  const std::vector<double> here{5, 6}, there{50, 6};
  const auto refused = [&](const std::vector<double>& x, const std::vector<double>& z) {
    Complaints out;
    return linearize(*model, sample_of(z), {{&target, x, 10.0, 1e-8}}, {}, out).result.refusal;
  };
  CHECK(refused(here, {0.1, NAN, 5, 6, NAN}) == Refusal::unsupported);
  CHECK(refused(there, {NAN, NAN, 5, 6, NAN}) == Refusal::invalid);
  CHECK(refused(there, {0.1, NAN, NAN, 6, NAN}) == Refusal::invalid);
  const AdditiveKind four(4, "m");
  CHECK_THROWS_AS(bind<Bearing>({{{"sigma", 0.01}}, {{"target", &four}}, {"elevation"}}), ComponentError);
  CHECK_THROWS_AS(bind<Bearing>({{{"sigma", 0.01}}, {{"target", &target}}, {"elevation", "observer_east"}}),
                  ComponentError);
}
