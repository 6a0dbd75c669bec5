// SPDX-License-Identifier: Apache-2.0
// frames: local_from_geodetic and geodetic_from_local: signs, one against the other, what is missing.
#include "frames/local_position.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"

namespace local_position_test {

using namespace binnacle;
using namespace binnacle::frames;
using namespace binnacle::test;
using binnacle::test::Contains;

namespace {

constexpr double degree = std::numbers::pi / 180, none = std::numeric_limits<double>::quiet_NaN();
const nlohmann::json at_karlsruhe{{"origin", {{"lat", 49.01 * degree}, {"lon", 8.43 * degree}, {"height", 115}}}};

template <class Component>
std::vector<double> made_of(const std::vector<double>& fields, const std::vector<std::string>& without = {},
                            const nlohmann::json& more = nlohmann::json::object()) {
  static const ComponentSpec spec = Component::spec();
  Setup setup;
  setup.parameters = at_karlsruhe;
  setup.parameters.update(more);
  setup.without = without;
  const auto model = bind<Component>(setup);
  SampleView sample;
  sample.t = 5;
  sample.fields = fields.data();
  const auto made = binnacle::testing::TransformCaller(*model, spec).on(0, sample, nullptr);
  REQUIRE(made.damage.empty());
  REQUIRE(made.samples.size() == 1);
  REQUIRE(made.samples[0].t == 5);
  return made.samples[0].fields;
}

}  // namespace

TEST_CASE("local_from_geodetic: north, east, down and up have their signs", "[frames]") {
  const auto out = made_of<LocalFromGeodetic>({49.01 * degree + 1e-5, 8.43 * degree - 1e-5, 125, 3, -4, 0.5});
  REQUIRE(out.size() == 7);
  CHECK(out[0] == Approx(63.7).margin(0.2));   // R_m + h = 6.374e6 m, times 1e-5
  CHECK(out[1] == Approx(-41.9).margin(0.2));  // (R_t + h) cos(lat) = 4.19e6 m
  CHECK(out[2] == Approx(-10).margin(1e-3));
  CHECK(out[3] == -out[2]);
  CHECK(out[4] == Approx(3).margin(1e-4));
  CHECK(out[5] == Approx(-4).margin(1e-4));
  CHECK(out[6] == Approx(0.5).margin(1e-4));
  const auto position_alone =
      made_of<LocalFromGeodetic>({49.01 * degree, 8.43 * degree, 115, none, none, none}, {"vn", "ve", "vd"});
  CHECK(std::abs(position_alone[0]) < 1e-8);
  CHECK(std::isnan(position_alone[4]));
}

TEST_CASE("geodetic_from_local is the inverse, with down or with up", "[frames]") {
  const std::vector<double> local{20000, -15000, 300, 3, -4, 0.5};
  const auto lla = made_of<GeodeticFromLocal>(local);
  REQUIRE(lla.size() == 6);
  CHECK(lla[0] > 49.18 * degree);
  CHECK(lla[1] < 8.23 * degree);
  CHECK(lla[2] == Approx(115 - 300 + (20000.0 * 20000 + 15000.0 * 15000) / (2 * 6.38e6)).margin(0.5));
  CHECK(std::abs(lla[3] - 3) > 1e-3);  // the axes of the place are others
  const auto back = made_of<LocalFromGeodetic>(lla);
  for (const std::size_t i : {0U, 1U, 2U}) CHECK(back[i] == Approx(local[i]).margin(1e-7));
  for (const std::size_t i : {3U, 4U, 5U}) CHECK(back[i + 1] == Approx(local[i]).margin(1e-9));
  CHECK(made_of<GeodeticFromLocal>({20000, -15000, -300, 3, -4, -0.5}, {}, {{"vertical", "up"}}) == lla);
}

TEST_CASE("local coordinates without an origin are refused", "[frames]") {
  CHECK_THROWS_WITH(bind<LocalFromGeodetic>({}), Contains("local coordinates need an origin") && Contains("(/origin)"));
}

}  // namespace local_position_test
