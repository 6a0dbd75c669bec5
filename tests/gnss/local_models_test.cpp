// SPDX-License-Identifier: Apache-2.0
// Processes of a receiver without inertial sensors in local axes, and tracks turned into geodetic terms.
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "../../plugins/gnss_range/ecef_pv.hpp"
#include "../../plugins/gnss_range/geodetic_track.hpp"
#include "../../plugins/gnss_range/ned_pv.hpp"
#include "../plugins/bind.hpp"
#include "../plugins/model_check.hpp"
#include "catch.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace local_models_test {

using namespace binnacle;
using namespace binnacle::gnss_range;
using namespace binnacle::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const Vector3d berlin(0.9165, 0.2334, 80);
const AdditiveKind ecef_position("position.ecef", 3, "m"), ecef_velocity("velocity.ecef", 3, "m/s"),
    ned_velocity("velocity.ned", 3, "m/s");
const PositionKind geodetic;

Step step(double dt) { return {0, nanoseconds(dt), dt, {}}; }
std::vector<Step> hundredths(double dt) {
  std::vector<Step> list;
  for (int i = 0; i < 100; ++i)
    list.push_back({nanoseconds(dt / 100 * i), nanoseconds(dt / 100 * (i + 1)), dt / 100, {}});
  return list;
}

}  // namespace

TEST_CASE("ecef_pv with a density along the vertical of its own") {
  const auto model = bind<EcefPv>({{{"S_a_horizontal", 2.0}, {"S_a_vertical", 0.05}, {"S_v", 0.01}},
                                   {{"position", &ecef_position}, {"velocity", &ecef_velocity}},
                                   {}});
  const ProcessCheck check(*model, EcefPv::spec());
  const Vector3d r = strapdown::ecef_from_lla(berlin);
  const PortStates ports{{&ecef_position, {r[0], r[1], r[2]}, 1, 1e-9}, {&ecef_velocity, {1, 2, 3}, 1}};
  REQUIRE_NO_COMPLAINTS(check.transition(ports, step(2), {}, {1e-9}));
  REQUIRE_NO_COMPLAINTS(check.noise(ports, step(2), hundredths(2), {}, 1e-6));  // up turns with the way
  REQUIRE_NO_COMPLAINTS(check.zero_step(ports, step(0), {}));
  Complaints out;
  const auto noise = check.propagate(ports, step(2), {}, out).noise;
  const Matrix3d C_ne = strapdown::C_en(berlin[0], berlin[1]).transpose();
  const Matrix3d velocity = C_ne * noise.at({1, 1}) * C_ne.transpose();
  CHECK((velocity - Matrix3d(Vector3d(4, 4, 0.1).asDiagonal())).cwiseAbs().maxCoeff() < 1e-9);
  const Matrix3d position = C_ne * noise.at({0, 0}) * C_ne.transpose();
  CHECK(std::abs(position(0, 0) - (2 * 8.0 / 3 + 0.02)) < 1e-9);
  CHECK(std::abs(position(2, 2) - (0.05 * 8.0 / 3 + 0.02)) < 1e-9);
}

TEST_CASE("ecef_pv wants one density or two") {
  const Ports ports{{"position", &ecef_position}, {"velocity", &ecef_velocity}};
  for (const nlohmann::json& wrong : {nlohmann::json::object(), nlohmann::json{{"S_a", 1}, {"S_a_vertical", 1}},
                                      nlohmann::json{{"S_a_horizontal", 1}}})
    CHECK_THROWS_AS(bind<EcefPv>({wrong, ports, {}}), ComponentError);
  // Two equal ones are one.
  const auto one = bind<EcefPv>({{{"S_a", 0.3}}, ports, {}});
  const auto two = bind<EcefPv>({{{"S_a_horizontal", 0.3}, {"S_a_vertical", 0.3}}, ports, {}});
  const PortStates at{{&ecef_position, {4e6, 1e6, 5e6}, 1, 1e-9}, {&ecef_velocity, {1, 2, 3}, 1}};
  Complaints out;
  const auto a = ProcessCheck(*one, EcefPv::spec()).propagate(at, step(1.5), {}, out).noise;
  const auto b = ProcessCheck(*two, EcefPv::spec()).propagate(at, step(1.5), {}, out).noise;
  for (const auto& [key, block] : a) CHECK(block.isApprox(b.at(key), 1e-12));
}

TEST_CASE("ned_pv: transition, noise, and the same way as ecef_pv") {
  const auto model = bind<NedPv>({{{"S_a_horizontal", 2.0}, {"S_a_vertical", 0.05}, {"S_v", 0.01}},
                                  {{"position", &geodetic}, {"velocity", &ned_velocity}},
                                  {}});
  const ProcessCheck check(*model, NedPv::spec());
  const PortStates ports{{&geodetic, {berlin[0], berlin[1], berlin[2]}, 10, 1e-8}, {&ned_velocity, {900, -700, 30}, 1}};
  REQUIRE_NO_COMPLAINTS(check.transition(ports, step(2), {}, {1e-8}));
  REQUIRE_NO_COMPLAINTS(check.noise(ports, step(2), hundredths(2), {}, 1e-3, 1e-6));
  REQUIRE_NO_COMPLAINTS(check.zero_step(ports, step(0), {}));
  Complaints out;
  const auto made = check.propagate(ports, step(2), {}, out);
  const Vector3d after = vector_at<3>(made.x_plus[0].data());
  const Vector3d way = strapdown::C_en(berlin[0], berlin[1]).transpose() *
                       (strapdown::ecef_from_lla(after) - strapdown::ecef_from_lla(berlin));
  CHECK((way - 2 * Vector3d(900, -700, 30)).norm() < 1.0);  // the earth falls away under 2 km by 0.4 m
  CHECK(std::abs(made.noise.at({1, 1})(2, 2) - 0.1) < 1e-12);
  CHECK(std::abs(made.noise.at({1, 1})(0, 0) - 4) < 1e-12);
}

TEST_CASE("a geodetic track is where its ECEF positions are") {
  const auto track = bind<GeodeticTrack>();
  const ComponentSpec spec = GeodeticTrack::spec();
  const binnacle::testing::TransformCaller caller(*track, spec);
  auto memory = caller.fresh_memory(0);
  const Vector3d r = strapdown::ecef_from_lla(berlin), v = strapdown::C_en(berlin[0], berlin[1]) * Vector3d(3, -4, 0.5);
  std::vector<double> fields{r[0], r[1], r[2], v[0], v[1], v[2]};
  SampleView sample;
  sample.t = 17;
  sample.fields = fields.data();
  sample.available = true;
  const auto made = caller.on(0, sample, memory.data());
  REQUIRE(made.samples.size() == 1);
  CHECK(made.samples[0].t == 17);
  CHECK((vector_at<3>(made.samples[0].fields.data()) - berlin).norm() < 1e-8);
  CHECK((vector_at<3>(made.samples[0].fields.data() + 3) - Vector3d(3, -4, 0.5)).norm() < 1e-9);
  fields[1] = std::nan("");
  CHECK(caller.on(0, sample, memory.data()).samples.empty());
}

}  // namespace local_models_test
