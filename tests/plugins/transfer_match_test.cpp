// SPDX-License-Identifier: Apache-2.0
// Plugin transfer_match: the mounting's laws and feedback, residuals and Jacobians of both matches, wrong signs seen,
// and an alignment without noise.
#include "../../plugins/transfer_match/dcm_match.hpp"
#include "../../plugins/transfer_match/mounting_block.hpp"
#include "../../plugins/transfer_match/velocity_match.hpp"

#include <cstdlib>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "bind.hpp"
#include "binnacle/composition.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "ship_voyage.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace transfer_match_test {

using namespace binnacle;
using namespace binnacle::test;
using namespace binnacle::transfer_match;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using strapdown::attitude_plus;
using strapdown::dcm_from_quaternion;
using strapdown::quaternion_from_euler;
using strapdown::quaternion_product;

namespace {

constexpr double degree = M_PI / 180, mil = M_PI / 3200, arcmin = degree / 60;
const nlohmann::json upright{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};

std::vector<double> values(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

std::unique_ptr<MountingBlock> mounting_block() {
  return bind<MountingBlock>({{{"nominal", upright}, {"angles", 0}}, {}, {}});
}

SampleView sample_of(const std::vector<double>& fields) {
  SampleView sample;
  sample.t = 0;
  sample.fields = fields.data();
  return sample;
}

/// A model whose H of one port is multiplied.
class Mutated final : public MeasurementModel {
 public:
  Mutated(const MeasurementModel& model, std::size_t read, double factor)
      : model_(model), read_(read), factor_(factor) {}
  const MeasurementDeclaration& declaration() const noexcept override { return model_.declaration(); }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const Result result = model_.linearize(in, out);
    if (result && out.H) out.H[Port(declaration().read_ports[read_], 1, 1)].as() *= factor_;
    return result;
  }

 private:
  const MeasurementModel& model_;
  std::size_t read_;
  double factor_;
};

/// A mounting whose feedback goes the wrong way.
class WrongFeedback final : public StateBlock {
 public:
  explicit WrongFeedback(const StateBlock& block) : block_(block) {}
  const StateBlockDeclaration& declaration() const noexcept override { return block_.declaration(); }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    const Vector3d minus = -delta.as<3>();
    block_.plus(x, minus, result);
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override { block_.minus(y, x, delta); }
  void read(ConstVectorView x, VectorView outputs) const override { block_.read(x, outputs); }
  Result write(ConstVectorView outputs, VectorView x) const override { return block_.write(outputs, x); }

 private:
  const StateBlock& block_;
};

struct Attitudes {
  const char* name;
  Vector3d master, mounting, error;  // rad: roll pitch yaw; from nominal; of the estimate
};
const Attitudes attitudes[] = {
    {"level", {0.003, -0.001, 0.7}, {0.01, -0.02, 0.015}, {0, 0, 0}},
    {"small errors", {0.003, -0.001, -2.4}, {0.01, -0.02, 0.015}, {0.02, -0.01, 0.03}},
    {"large errors", {0.2, -0.3, 2.9}, {0.3, -0.2, 0.15}, {0.5, -0.4, 0.6}},
};

/// dcm_match on an attitude that is off by `error`.
struct DcmBench {
  AttitudeKind attitude;
  std::unique_ptr<MountingBlock> mounting = mounting_block();
  std::unique_ptr<DcmMatch> model = bind<DcmMatch>({{{"sigma", 0.2 * arcmin}, {"jacobian", "tangent"}},
                                                    {{"attitude", &attitude}, {"mounting", mounting.get()}},
                                                    {}});

  PortStates ports(const Attitudes& at) const {
    std::vector<double> q_SM(4);
    mounting->write(at.mounting, q_SM);
    const Vector4d q_nS = quaternion_product(quaternion_from_euler(at.master), Vector4d(vector_at<4>(q_SM.data())));
    return {{&attitude, values(attitude_plus(q_nS, at.error)), 1e-2, 4e-16}, {mounting.get(), q_SM, 1e-2, 4e-16}};
  }
};

struct VelocityBench {
  AdditiveKind velocity{"velocity.ned", 3, "m/s"}, lever_arm{3, "m"}, gyro_bias{3, "rad/s"};
  AttitudeKind attitude;
  bool has_lever_arm;
  std::unique_ptr<VelocityMatch> model;

  VelocityBench(const std::string& axes, bool with_lever_arm, std::vector<std::string> without = {})
      : has_lever_arm(with_lever_arm) {
    Setup setup{{{"sigma", {0.2, 0.3, 0.4}}, {"axes", axes}}, {{"velocity", &velocity}}, std::move(without)};
    if (with_lever_arm)
      setup.ports.insert({{"lever_arm", &lever_arm}, {"attitude", &attitude}, {"gyro_bias", &gyro_bias}});
    model = bind<VelocityMatch>(setup);
  }
  PortStates ports() const {
    PortStates all{{&velocity, {4, -3, 0.2}, 0.1, 1e-15}, {}, {}, {}};
    if (has_lever_arm) {
      all[1] = {&lever_arm, {12, -3, 5}, 0.1, 1e-15};
      all[2] = {&attitude, values(quaternion_from_euler({0.2, 1.3, -0.4})), 1e-2, 1e-15};
      all[3] = {&gyro_bias, {0.01, -0.02, 0.03}, 1e-2, 1e-15};
    }
    return all;
  }
};

const std::vector<double> master_sample{4.1, -2.8, 0.3, 0.1, -0.2, 0.7, 0.6};  // vn ve vd roll pitch yaw lat

}  // namespace

TEST_CASE("mounting: kind, laws, readable angles from nominal", "[transfer_match]") {
  const auto block = mounting_block();
  REQUIRE(block->declaration().kind == "mounting");
  for (const Vector3d& m : {Vector3d(0, 0, 0), Vector3d(0.02, -0.01, 0.03), Vector3d(1.2, -0.7, 0.4)}) {
    std::vector<double> x(4);
    REQUIRE(block->write(m, x));
    Vector3d read;
    block->read(x, read);
    REQUIRE((read - m).norm() < 1e-14);
    REQUIRE_NO_COMPLAINTS(check_block(*block, x, 1.0, 1e-14, 1e-13));
    REQUIRE_NO_COMPLAINTS(check_reset(*block, x, Vector3d(0.1, -0.2, 0.3), {1e-8}));
    REQUIRE_NO_COMPLAINTS(check_outputs(*block, x, 1e-4, 1e-7));
  }
  double x[4];
  const double nothing[3] = {0, 0, 0}, too_far[3] = {3, 3, 0}, none[3] = {std::nan(""), 0, 0};
  REQUIRE(block->write(nothing, x));
  const Matrix3d nominal = dcm_from_quaternion(vector_at<4>(x));
  REQUIRE((nominal - (Matrix3d() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished()).norm() < 1e-15);
  REQUIRE(block->write(too_far, x).refusal == Refusal::invalid);
  REQUIRE(block->write(none, x).refusal == Refusal::invalid);
}

TEST_CASE("mounting: nominal as a matrix or as angles, not as both, and only rotations", "[transfer_match]") {
  const auto by_angles = bind<MountingBlock>({{{"angles", {0, M_PI / 2, 0}}}, {}, {}});
  const double nothing[3] = {0, 0, 0};
  double one[4], other[4];
  REQUIRE(by_angles->write(nothing, one));
  REQUIRE(mounting_block()->write(nothing, other));
  Vector3d apart;
  by_angles->minus(one, other, apart);
  REQUIRE(apart.norm() < 1e-15);
  const nlohmann::json reflection{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}, stretched{{1, 0, 0}, {0, 1.01, 0}, {0, 0, 1}};
  REQUIRE_THROWS_AS(bind<MountingBlock>({{{"nominal", upright}, {"angles", {0, 1, 0}}}, {}, {}}), ComponentError);
  REQUIRE_THROWS_AS(bind<MountingBlock>({{{"nominal", reflection}}, {}, {}}), ComponentError);
  REQUIRE_THROWS_AS(bind<MountingBlock>({{{"nominal", stretched}}, {}, {}}), ComponentError);
}

TEST_CASE("mounting: the feedback is the paper's (5), in the master's axes", "[transfer_match]") {
  const auto block = mounting_block();
  const Vector3d m{0.02, -0.01, 0.03}, delta{1e-5, -2e-5, 3e-5};
  double x[4], corrected[4];
  REQUIRE(block->write(m, x));
  block->plus(x, delta, corrected);
  const Matrix3d C = dcm_from_quaternion(vector_at<4>(x)), C_true = dcm_from_quaternion(vector_at<4>(corrected));
  REQUIRE((C - (Matrix3d::Identity() - strapdown::skew(delta)) * C_true).norm() < 1e-8);
  REQUIRE((C - (Matrix3d::Identity() + strapdown::skew(delta)) * C_true).norm() > 1e-5);
}

TEST_CASE("dcm_match: the residual is psi - C_M dmu to first order", "[transfer_match]") {
  const DcmBench bench;
  const Attitudes& at = attitudes[0];
  const Vector3d psi{1e-5, -2e-5, 3e-5}, mu{2e-5, 1e-5, -3e-5};
  PortStates ports = bench.ports(at);
  // The estimates are truth ⊟ δ.
  const Vector3d minus_psi = -psi, minus_mu = -mu;
  ports[0].block->plus(ports[0].x, minus_psi, ports[0].x);
  ports[1].block->plus(ports[1].x, minus_mu, ports[1].x);
  Complaints out;
  const auto fields = values(at.master);
  const Measured m = linearize(*bench.model, sample_of(fields), ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  const Matrix3d C_M = dcm_from_quaternion(quaternion_from_euler(at.master));
  REQUIRE((m.residual - (psi - C_M * mu)).norm() < 1e-8);
  REQUIRE((m.H[0] - Matrix3d::Identity()).norm() < 1e-4);
  REQUIRE((m.H[1] + C_M).norm() < 1e-4);
  REQUIRE((m.R - Matrix3d::Identity() * std::pow(0.2 * arcmin, 2)).norm() < 1e-20);
}

TEST_CASE("dcm_match: H against differences, for large residuals too", "[transfer_match]") {
  const DcmBench bench;
  for (const Attitudes& at : attitudes) {
    INFO(at.name);
    const auto fields = values(at.master);
    REQUIRE_NO_COMPLAINTS(
        check_measurement(*bench.model, DcmMatch::spec(), sample_of(fields), bench.ports(at), {}, {1e-8}, 1e-15));
    for (const std::size_t read : {0U, 1U})
      REQUIRE_FALSE(check_measurement(Mutated(*bench.model, read, -1), DcmMatch::spec(), sample_of(fields),
                                      bench.ports(at), {}, {1e-8}, 1e-15)
                        .empty());
    PortStates turned = bench.ports(at);
    const WrongFeedback wrong(*bench.mounting);
    turned[1].block = &wrong;
    REQUIRE_FALSE(
        check_measurement(*bench.model, DcmMatch::spec(), sample_of(fields), turned, {}, {1e-8}, 1e-15).empty());
  }
}

TEST_CASE("dcm_match: refusals", "[transfer_match]") {
  const DcmBench bench;
  Complaints out;
  Attitudes far = attitudes[0];
  far.error = {0, 0, 1.6};
  const auto fields = values(far.master);
  REQUIRE(linearize(*bench.model, sample_of(fields), bench.ports(far), {}, out).result.refusal == Refusal::unsupported);
  const std::vector<double> bad{0, std::nan(""), 0};
  REQUIRE(linearize(*bench.model, sample_of(bad), bench.ports(attitudes[0]), {}, out).result.refusal ==
          Refusal::invalid);
}

TEST_CASE("dcm_match: the chord is right to second order in errors of attitude and mounting", "[transfer_match]") {
  const AttitudeKind attitude;
  const auto mounting = mounting_block();
  const Vector3d master(0.003, -0.001, 0.7), psi(0.02, -0.013, 0.025), mu(-0.015, 0.022, 0.018);
  const Vector4d q_nM = quaternion_from_euler(master);
  std::vector<double> q_SM(4);
  const Vector3d zero = Vector3d::Zero();
  mounting->write(zero, q_SM);
  // The estimate is the nominal one; the master shows what is true.
  const Vector4d q_nS = quaternion_product(q_nM, Vector4d(vector_at<4>(q_SM.data())));
  const Vector4d true_nS = attitude_plus(q_nS, psi), true_SM = attitude_plus(Vector4d(vector_at<4>(q_SM.data())), mu);
  const Matrix3d true_C_M = dcm_from_quaternion(true_nS) * dcm_from_quaternion(true_SM).transpose();
  const Vector3d shown = strapdown::euler_from_quaternion(strapdown::quaternion_from_dcm(true_C_M));
  const auto miss = [&](const char* jacobian) {
    const auto model = bind<DcmMatch>({{{"sigma", 0.2 * arcmin}, {"jacobian", jacobian}},
                                       {{"attitude", &attitude}, {"mounting", mounting.get()}},
                                       {}});
    double r[3], H_psi[9] = {}, H_mu[9] = {}, R[9] = {};
    std::int64_t keys[3] = {};
    const MatrixView H[] = {{H_psi, 3, 3, 3}, {H_mu, 3, 3, 3}};
    MeasurementOutput out{0, {r, 3}, H, {R, 3, 3, 3}, keys};
    const double* x[] = {q_nS.data(), q_SM.data()};
    REQUIRE(model->linearize({sample_of(values(shown)), {}, x, {}, {}, {}, {}}, out));
    return (vector_at<3>(r) - H[0].as<3, 3>() * psi - H[1].as<3, 3>() * mu).norm();
  };
  CHECK(miss("tangent") > 1e-4);
  CHECK(miss("chord") < 2e-5);
}

TEST_CASE("velocity_match: two rows or three, with and without a lever arm", "[transfer_match]") {
  const double drive[3] = {0.1, 0.2, -0.3};
  for (const bool with_lever_arm : {false, true})
    for (const auto& [axes, rows] : {std::pair("horizontal", 2), std::pair("all", 3)}) {
      INFO(axes << ", lever_arm " << with_lever_arm);
      const VelocityBench bench(axes, with_lever_arm);
      REQUIRE(bench.model->declaration().max_rows == rows);
      Complaints out;
      const Measured m = linearize(*bench.model, sample_of(master_sample), bench.ports(), {0, drive}, out);
      REQUIRE_NO_COMPLAINTS(out);
      REQUIRE(m.R(1, 1) == 0.3 * 0.3);
      REQUIRE_NO_COMPLAINTS(check_measurement(*bench.model, VelocityMatch::spec(), sample_of(master_sample),
                                              bench.ports(), {0, drive}, {1e-8}, 1e-14));
      for (std::size_t read = 0; read < bench.model->declaration().read_ports.size(); ++read)
        REQUIRE_FALSE(check_measurement(Mutated(*bench.model, read, -1), VelocityMatch::spec(),
                                        sample_of(master_sample), bench.ports(), {0, drive}, {1e-8}, 1e-14)
                          .empty());
      if (!with_lever_arm) {
        REQUIRE(std::abs(m.residual[0] - 0.1) < 1e-15);
        REQUIRE(std::abs(m.residual[1] - 0.2) < 1e-15);
      }
    }
}

TEST_CASE("velocity_match: a rigid ship moves the slave as its lever arm says", "[transfer_match]") {
  // Truth by geometry: both units in earth axes, the slave's place differentiated numerically.
  const Voyage voyage;
  const Vector3d lever_arm{30, -8, -5};
  const double t = 12.3, h = 1e-3;
  const auto master = [&](double time) {  // the voyage is the master's
    return strapdown::ecef_from_lla(voyage.at(time).lla);
  };
  const auto slave = [&](double time) -> Vector3d {
    const strapdown::Navigation now = voyage.at(time);
    const Matrix3d C_nM = dcm_from_quaternion(quaternion_from_euler(voyage.master_angles(time)));
    return master(time) + strapdown::C_en(now.lla[0], now.lla[1]) * (C_nM * lever_arm);
  };
  const strapdown::Navigation now = voyage.at(t);
  const Vector3d v_slave =
      strapdown::C_en(now.lla[0], now.lla[1]).transpose() * (slave(t + h) - slave(t - h)) / (2 * h);
  const VelocityBench bench("all", true);
  PortStates ports = bench.ports();
  ports[0].x = values(v_slave), ports[1].x = values(lever_arm), ports[2].x = values(now.q_nb), ports[3].x = {0, 0, 0};
  const Vector3d rate = voyage.rate(t), angles = voyage.master_angles(t);
  const std::vector<double> sample{now.v_n[0], now.v_n[1], now.v_n[2], angles[0], angles[1], angles[2], now.lla[0]};
  Complaints out;
  const Measured m = linearize(*bench.model, sample_of(sample), ports, {0, rate.data()}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE((v_slave - now.v_n).norm() > 1e-2);
  REQUIRE(m.residual.norm() < 2e-4);  // the transport rate turns the axes, not the ship: 30 m × 8e-7 rad/s
}

TEST_CASE("velocity_match: what it needs and what it refuses", "[transfer_match]") {
  REQUIRE_THROWS_AS(VelocityBench("all", false, {"vd"}), ComponentError);
  REQUIRE_THROWS_AS(VelocityBench("horizontal", true, {"yaw"}), ComponentError);
  const VelocityBench bare("horizontal", false, {"vd", "roll", "pitch", "yaw", "lat"});
  Complaints out;
  REQUIRE(linearize(*bare.model, sample_of(master_sample), bare.ports(), {}, out).result);
  const VelocityBench with_lever_arm("all", true);
  REQUIRE(linearize(*with_lever_arm.model, sample_of(master_sample), with_lever_arm.ports(), {}, out).result.refusal ==
          Refusal::unsupported);
  std::vector<double> bad = master_sample;
  bad[1] = std::nan("");
  REQUIRE(linearize(*bare.model, sample_of(bad), bare.ports(), {}, out).result.refusal == Refusal::invalid);
}

namespace {

/// Ends of an alignment: errors of the slave's attitude (north, east, down) and of the mounting [rad].
struct Aligned {
  Vector3d attitude, mounting;
};

/// The filter of configs/transfer_alignment/base.json on samples that a program pushes; `change` is merged over it.
constexpr const char* alignment_config = R"json({
    "binnacle": 1,
    "filters": {"align": {
      "blocks": {
        "position": {"type": "navigation/position", "estimate": []},
        "velocity": {"type": "navigation/velocity", "sigma": "0.257 m/s", "estimate": ["north", "east"]},
        "attitude": {"type": "navigation/attitude", "mounting": [0, "90 deg", 0], "sigma": "1 deg"},
        "mounting": {"type": "transfer_match/mounting", "nominal": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
                     "init": {"mx": 0, "my": 0, "mz": 0}, "sigma": "1 deg"}},
      "process": {
        "strapdown": {"type": "psi_error", "input": "imu", "axes": "computed", "gyro_noise": 0, "accel_noise": 0,
                      "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude"}},
        "mounted": {"type": "random_constant", "blocks": {"x": "mounting"}}},
      "measurements": {"match": {"channel": "mins", "stack": {
        "velocity": {"type": "velocity_match", "blocks": {"velocity": "velocity"}, "sigma": 1e-4},
        "attitude": {"type": "dcm_match", "blocks": {"attitude": "attitude", "mounting": "mounting"},
                     "sigma": 1e-7}}}}}}})json";

struct PushedFields {
  nlohmann::ordered_json imu, mins;  // in the order in which their values are pushed
};

PushedFields pushed_fields() {
  const auto level = [](const std::vector<std::string>& names, const char* unit) {
    nlohmann::ordered_json fields;
    for (const auto& name : names) fields[name] = {{"unit", unit}};
    return fields;
  };
  PushedFields of;
  of.mins = level({"vn", "ve", "vd"}, "m/s");
  for (const char* axis : {"wx", "wy", "wz"}) of.imu[axis] = {{"unit", "rad"}, {"kind", "increment"}};
  for (const char* axis : {"fx", "fy", "fz"}) of.imu[axis] = {{"unit", "m/s"}, {"kind", "increment"}};
  of.mins.update(level({"roll", "pitch", "yaw"}, "rad"));
  return of;
}

Aligned align(const nlohmann::json& change) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  const auto [imu, mins] = pushed_fields();
  const Voyage voyage;
  const strapdown::Navigation start = voyage.at(0);
  // As the MINS says it: the nominal mounting, so the attitude is off by the whole misalignment.
  const Vector3d angles = voyage.master_angles(0);
  nlohmann::json config = nlohmann::json::parse(alignment_config);
  auto& blocks = config["filters"]["align"]["blocks"];
  blocks["position"]["init"] = {{"lat", start.lla[0]}, {"lon", start.lla[1]}, {"height", start.lla[2]}};
  blocks["velocity"]["init"] = {{"vn", start.v_n[0]}, {"ve", start.v_n[1]}, {"vd", start.v_n[2]}};
  blocks["attitude"]["init"] = {{"roll", angles[0]}, {"pitch", angles[1]}, {"yaw", angles[2]}};
  config["filters"]["align"].merge_patch(change);
  nlohmann::ordered_json ordered = config;  // the order of a channel's fields is that in which they are pushed
  ordered["sources"]["imu"] = {{"type", "pushed"}, {"fields", imu}};
  ordered["sources"]["mins"] = {{"type", "pushed"}, {"fields", mins}};
  const auto composition = Composition::parse(ordered.dump(), "alignment.json");
  Session filter(composition);
  const auto imu_channel = filter.channel("imu"), mins_channel = filter.channel("mins");
  const VoyageSamples samples(voyage, 100.0, 0.01, VoyageSamples::Increments::integrals);
  for (std::size_t k = 0; k < samples.steps().size(); ++k) {
    const InputSample& sample = samples.steps()[k].samples[0];
    filter.push(imu_channel, sample.t0, sample.t1, {sample.fields, 6});
    if ((k + 1) % 20 != 0) continue;
    const double t = seconds(sample.t1);
    const strapdown::Navigation now = voyage.at(t);
    const Vector3d master = voyage.master_angles(t);
    const double fields[6] = {now.v_n[0], now.v_n[1], now.v_n[2], master[0], master[1], master[2]};
    filter.push(mins_channel, no_time, sample.t1, fields);
  }
  REQUIRE(filter.healthy(FilterId{0}));
  REQUIRE(filter.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] == 500);
  const auto state = filter.state(FilterId{0});
  const auto quaternion = [&](const std::string& name) -> Vector4d {
    for (const BlockInfo& block : composition->filters()[0].blocks)
      if (block.name == name) return vector_at<4>(state.data() + block.stored_offset);
    throw std::logic_error("no such block");
  };
  const Vector4d q_nS = quaternion("attitude"), q_SM = quaternion("mounting");
  return {strapdown::attitude_minus(voyage.at(100.0).q_nb, q_nS), strapdown::attitude_minus(voyage.mounting(), q_SM)};
}

}  // namespace

TEST_CASE("an alignment without noise finds attitude and mounting", "[transfer_match]") {
  for (const char* axes : {"computed", "true"}) {
    const Aligned aligned = align({{"process", {{"strapdown", {{"axes", axes}}}}}});
    INFO(axes << ": attitude " << aligned.attitude.transpose() / mil << " mil, mounting "
              << aligned.mounting.transpose() / mil << " mil");
    CHECK(aligned.attitude.norm() < 0.01 * mil);
    CHECK(aligned.mounting.norm() < 0.01 * mil);
  }
}

}  // namespace transfer_match_test
