// SPDX-License-Identifier: Apache-2.0
// Plugin gnss_fix: residuals, Jacobians, the receiver's own standard deviations.
#include <cmath>

#include "../../plugins/gnss_fix/position_fix.hpp"
#include "../../plugins/gnss_fix/pv_fix.hpp"
#include "../../plugins/gnss_fix/velocity_fix.hpp"

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace gnss_fix_test {

using namespace binnacle;
using namespace binnacle::gnss_fix;
using namespace binnacle::test;

namespace {

const std::vector<std::string> no_position_sd{"position_sd_n", "position_sd_e", "position_sd_d"};

SampleView sample_of(const std::vector<double>& fields) {
  SampleView sample;
  sample.t = 0;
  sample.fields = fields.data();
  return sample;
}

}  // namespace

TEST_CASE("position fix: residual and H at several places", "[gnss_fix]") {
  const PositionKind position;
  const auto model = bind<PositionFix>({{}, {{"position", &position}}, {}});
  REQUIRE(model->declaration().groups[0].port == 0);
  for (const auto& [lat, lon, height] : {std::array{0.65, 2.2, 60.0}, std::array{-0.59, -1.2, 10000.0},
                                         std::array{1.4, 3.14159, 100.0}, std::array{0.0, 0.0, -50.0}}) {
    const std::vector<double> x{lat, lon, height}, offset{12.0, -7.0, 3.0};
    std::vector<double> z(3);
    position.plus(x, offset, z);
    z.insert(z.end(), {1.0, 2.0, 4.0});
    const PortStates ports{{&position, x, 10.0, 1e-8}};
    Complaints out;
    const Measured m = linearize(*model, sample_of(z), ports, {}, out);
    REQUIRE((m.residual - Eigen::Vector3d(12, -7, 3)).norm() < 1e-8);
    REQUIRE(m.R.isApprox(Eigen::Vector3d(1, 4, 16).asDiagonal().toDenseMatrix()));
    // H = I but for what the radii change over the residual: |r| (1 + tan(lat))/R.
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, PositionFix::spec(), sample_of(z), ports, {},
                                            {15 / 6.35e6 * (1 + std::abs(std::tan(lat)))}, 1e-8));
  }
}

TEST_CASE("position fix: a bias is what the receiver adds to the position", "[gnss_fix]") {
  const PositionKind position;
  const AdditiveKind bias(3, "m");
  const auto model = bind<PositionFix>({{}, {{"position", &position}, {"bias", &bias}}, {}});
  REQUIRE(model->declaration().groups[0].port == 0);
  const std::vector<double> x{0.65, 2.2, 60.0}, b{2.0, -3.0, 0.5}, offset{12.0, -7.0, 3.0};
  std::vector<double> z(3);
  position.plus(x, offset, z);
  z.insert(z.end(), {1.0, 2.0, 4.0});
  const PortStates ports{{&position, x, 10.0, 1e-8}, {&bias, b, 10.0}};
  Complaints out;
  const Measured m = linearize(*model, sample_of(z), ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE((m.residual - Eigen::Vector3d(10, -4, 2.5)).norm() < 1e-8);
  REQUIRE(m.R.isApprox(Eigen::Vector3d(1, 4, 16).asDiagonal().toDenseMatrix()));
  REQUIRE(m.H.size() == 2);
  REQUIRE(m.H[0] == Eigen::Matrix3d::Identity());
  REQUIRE(m.H[1] == Eigen::Matrix3d::Identity());
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, PositionFix::spec(), sample_of(z), ports, {}, {1e-5}, 1e-8));
}

TEST_CASE("position fix: without a bias the residual is z - p to the bit", "[gnss_fix]") {
  const PositionKind position;
  const auto model = bind<PositionFix>({{}, {{"position", &position}}, {}});
  REQUIRE(model->declaration().read_ports == std::vector<int>{0});
  const std::vector<double> x{0.65, 2.2, 60.0}, z{0.650001, 2.199999, 57.0, 1.0, 2.0, 4.0};
  Complaints out;
  const Measured m = linearize(*model, sample_of(z), {{&position, x, 10.0, 1e-8}, {}}, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE(m.residual == strapdown::position_minus({z[0], z[1], z[2]}, {x[0], x[1], x[2]}));
  REQUIRE(m.H.size() == 1);
}

TEST_CASE("velocity fix: residual and H", "[gnss_fix]") {
  const AdditiveKind velocity("velocity.ned", 3, "m/s");
  const auto model = bind<VelocityFix>({{}, {{"velocity", &velocity}}, {}});
  REQUIRE(model->declaration().groups[0].port == 0);
  const std::vector<double> z{5.0, -3.0, 0.5, 0.1, 0.2, 0.4};
  const PortStates ports{{&velocity, {4.0, -5.0, 1.0}}};
  Complaints out;
  const Measured m = linearize(*model, sample_of(z), ports, {}, out);
  REQUIRE((m.residual - Eigen::Vector3d(1, 2, -0.5)).norm() < 1e-15);
  REQUIRE(m.R.isApprox(Eigen::Vector3d(0.01, 0.04, 0.16).asDiagonal().toDenseMatrix()));
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, VelocityFix::spec(), sample_of(z), ports, {}, {1e-9}));
}

TEST_CASE("reported standard deviations: scale, floor, and what stands in", "[gnss_fix]") {
  const PositionKind position;
  const Ports ports{{"position", &position}};
  const PortStates states{{&position, {0.6, 2.0, 0.0}}};
  const auto roots = [&](const Setup& setup, std::vector<double> fields) {
    Complaints out;
    const Measured m = linearize(*bind<PositionFix>(setup), sample_of(fields), states, {}, out);
    REQUIRE(m.result);
    return Eigen::Vector3d(m.R.diagonal().cwiseSqrt());
  };
  const std::vector<double> fields{0.6, 2.0, 0.0, 0.2, 3.0, 5.0};
  REQUIRE(roots({{}, ports, {}}, fields).isApprox(Eigen::Vector3d(0.2, 3, 5)));
  REQUIRE(
      roots({{{"scale", 2.0}, {"floor", {0.5, 0.5, 20.0}}}, ports, {}}, fields).isApprox(Eigen::Vector3d(0.5, 6, 20)));
  REQUIRE(roots({{{"floor", 0.5}}, ports, {}}, fields).isApprox(Eigen::Vector3d(0.5, 3, 5)));
  // A channel without deviations: sigma as it is given, neither scaled nor floored.
  const double nan = std::nan("");
  REQUIRE(roots({{{"sigma", {2.0, 2.0, 4.0}}, {"scale", 3.0}, {"floor", 10.0}}, ports, no_position_sd},
                {0.6, 2.0, 0.0, nan, nan, nan})
              .isApprox(Eigen::Vector3d(2, 2, 4)));
  // A channel that reports two of three.
  REQUIRE(roots({{{"sigma", {9.0, 9.0, 4.0}}}, ports, {"position_sd_d"}}, {0.6, 2.0, 0.0, 0.2, 3.0, nan})
              .isApprox(Eigen::Vector3d(0.2, 3, 4)));
  REQUIRE_THROWS_AS(bind<PositionFix>({{}, ports, no_position_sd}), ComponentError);
  REQUIRE_THROWS_AS(bind<PositionFix>({{}, ports, {"position_sd_d"}}), ComponentError);
}

TEST_CASE("a fix that cannot be used is invalid, with a reason", "[gnss_fix]") {
  const PositionKind position;
  const AdditiveKind velocity("velocity.ned", 3, "m/s");
  const auto fix = bind<PositionFix>({{}, {{"position", &position}}, {}});
  const auto speed = bind<VelocityFix>({{}, {{"velocity", &velocity}}, {}});
  const PortStates at_position{{&position, {0.6, 2.0, 0.0}}}, at_velocity{{&velocity, {0, 0, 0}}};
  const double nan = std::nan("");
  const auto refuses = [](const MeasurementModel& model, const PortStates& ports, const std::vector<double>& fields) {
    Complaints out;
    const Measured m = linearize(model, sample_of(fields), ports, {}, out);
    return m.result.refusal == Refusal::invalid && std::string(m.result.reason).size() > 10;
  };
  REQUIRE_FALSE(refuses(*fix, at_position, {0.6, 2.0, 0.0, 1, 1, 1}));
  REQUIRE(refuses(*fix, at_position, {nan, 2.0, 0.0, 1, 1, 1}));
  REQUIRE(refuses(*fix, at_position, {1.6, 2.0, 0.0, 1, 1, 1}));
  REQUIRE(refuses(*fix, at_position, {0.6, 2.0, 0.0, 1, 0, 1}));
  REQUIRE(refuses(*fix, at_position, {0.6, 2.0, 0.0, 1, 1, -1}));
  REQUIRE(refuses(*fix, at_position, {0.6, 2.0, 0.0, nan, 1, 1}));
  REQUIRE(refuses(*speed, at_velocity, {0, 0, nan, 1, 1, 1}));
  REQUIRE(refuses(*speed, at_velocity, {0, 0, 0, 1, 1, 0}));
  // By the name of the field.
  Complaints out;
  const Measured m = linearize(*fix, sample_of({0.6, 2.0, 0.0, 1, 0, 1}), at_position, {}, out);
  REQUIRE(std::string(m.result.reason).find("position_sd_e") == 0);
}

TEST_CASE("position and velocity fix: ECEF to north east down, with the whole covariance", "[gnss_fix]") {
  const PositionKind position;
  const AdditiveKind velocity("velocity.ned", 3, "m/s");
  Setup setup{{}, {{"position", &position}, {"velocity", &velocity}}, {}};
  // The channel has a clock between position and velocity: the six are found by name.
  for (const char* name :
       {"position.x", "position.y", "position.z", "clock.bias", "velocity.x", "velocity.y", "velocity.z"})
    setup.covariance.push_back({name, ""});
  const auto model = bind<PvFix>(setup);

  const Eigen::Vector3d lla(0.65, 2.2, 60.0), v_n(4, -7, 0.5);
  const Eigen::Matrix3d C_en = strapdown::C_en(lla[0], lla[1]);
  std::vector<double> z(6), x(lla.data(), lla.data() + 3), offset{12.0, -7.0, 3.0}, there(3);
  position.plus(x, offset, there);
  Eigen::Map<Eigen::Vector3d>(z.data()) = strapdown::ecef_from_lla(Eigen::Map<Eigen::Vector3d>(there.data()));
  Eigen::Map<Eigen::Vector3d>(z.data() + 3) = C_en * v_n;
  const Eigen::Matrix<double, 7, 7> root =
      (Eigen::Matrix<double, 7, 7>::Random() + 3 * Eigen::Matrix<double, 7, 7>::Identity());
  const Eigen::Matrix<double, 7, 7> sigma = root * root.transpose();
  SampleView sample = sample_of(z);
  sample.covariance = sigma.data();

  const PortStates ports{{&position, x, 10.0, 1e-8}, {&velocity, {1.0, 2.0, 3.0}}};
  Complaints out;
  const Measured m = linearize(*model, sample, ports, {}, out);
  REQUIRE((m.residual.head<3>() - Eigen::Vector3d(12, -7, 3)).norm() < 1e-7);
  REQUIRE((m.residual.tail<3>() - (v_n - Eigen::Vector3d(1, 2, 3))).norm() < 1e-4);  // axes 14 m away turn by 2e-6 rad
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, PvFix::spec(), sample, ports, {}, {1e-5, 1e-8}, 1e-8));

  Eigen::Matrix<double, 6, 7> T = Eigen::Matrix<double, 6, 7>::Zero();
  T.block<3, 3>(0, 0) = C_en.transpose();
  T.block<3, 3>(3, 4) = C_en.transpose();
  REQUIRE((m.R - T * sigma * T.transpose()).norm() < 1e-4 * sigma.norm());
  REQUIRE(m.R.topRightCorner<3, 3>().norm() > 0.1);

  sample.covariance = nullptr;
  std::vector<double> buffer(64);
  REQUIRE_THROWS_AS((bind<PvFix>({{}, {{"position", &position}, {"velocity", &velocity}}, {}})), ComponentError);
}

}  // namespace gnss_fix_test
