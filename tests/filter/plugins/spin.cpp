// SPDX-License-Identifier: Apache-2.0
// Processes whose propagation is not linear, for tests of sigma points: an attitude that turns with a biased rate, a vehicle
// that drives where its heading points; and a derived value for linear ones to read.
#include <cmath>

#include <Eigen/Geometry>

#include "binnacle/plugin.hpp"

namespace {

using namespace binnacle;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Matrix3d skew(const Vector3d& v) {
  Matrix3d S;
  S << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return S;
}

Quaterniond exponential(const Vector3d& phi) {
  const double angle = phi.norm();
  return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, phi / angle)) : Quaterniond::Identity();
}

/// q⁺ = q ⊗ exp((rate (1 + growth·calls) − b) dt), the error of q on the left; `calls` is its memory, so that a call too many
/// shows. Refuses where the bias about x is beyond a limit.
class Spin : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "spin";
    spec.summary = "An attitude that turns, by a rate less a bias.";
    spec.parameters = {parameter::vector("rate", "rad/s", 3).required(),
                       parameter::number("growth", "1").defaults("0").about("of the rate with each call"),
                       parameter::number("noise", "rad/sqrt(s)").defaults("0"),
                       parameter::number("most", "rad/s").defaults("1e9").about("of the bias about x")};
    spec.ports = {advances("attitude", "attitude", "what turns"), reads("bias", "vector:3:rad/s", "of the rate")};
    spec.example = R"({"blocks": {"attitude": "attitude", "bias": "bias"}, "rate": [0, 0, 0.1]})";
    return spec;
  }
  explicit Spin(const Binding& binding)
      : rate_(binding.parameters().vector("rate")),
        growth_(binding.parameters().number("growth")),
        density_(std::pow(binding.parameters().number("noise"), 2)),
        most_(binding.parameters().number("most")),
        attitude_(binding.port("attitude")),
        bias_(binding.port("bias")),
        phi_(declaration_.couples(attitude_, bias_)),
        q_(declaration_.adds_noise(attitude_, attitude_, Structure::diagonal)),
        calls_(declaration_.keeps<double>()) {}
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    if (in.x[bias_][0] > most_) return Result::failed("the bias is too large");
    double& calls = in.memory[calls_];
    const Vector3d turn = in.step.dt * ((1 + growth_ * calls) * rate_ - in.x[bias_].as<3>());
    calls += 1;
    const auto q = in.x[attitude_].as<4>();
    const Quaterniond before(q[0], q[1], q[2], q[3]), after = before * exponential(turn);
    out.x[attitude_].as<4>() << after.w(), after.x(), after.y(), after.z();
    // exp(turn + d) = exp(J_l d) exp(turn)
    if (const BlockView phi = out.phi[phi_])
      phi.as<3, 3>() = -in.step.dt * before.toRotationMatrix() *
                       (Matrix3d::Identity() + 0.5 * skew(turn) + skew(turn) * skew(turn) / 6);
    if (const BlockView Q = out.Qd[q_]) Q.diagonal<3>().setConstant(density_ * in.step.dt);
    return Result::ok();
  }

 private:
  Vector3d rate_;
  double growth_, density_, most_;
  Port attitude_, bias_;
  PhiBlock phi_;
  QBlock q_;
  Memory<double> calls_;
};

/// p⁺ = p + v dt (cos ψ, sin ψ), ψ⁺ = ψ.
class Drive : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "drive";
    spec.summary = "Where a heading leads.";
    spec.parameters = {parameter::number("speed", "m/s").required(),
                       parameter::number("noise", "m/sqrt(s)").defaults("0"),
                       parameter::number("turn_noise", "rad/sqrt(s)").defaults("0")};
    spec.ports = {advances("position", "vector:2:m", "where it is"),
                  advances("heading", "vector:1:rad", "where it goes")};
    spec.example = R"({"blocks": {"position": "position", "heading": "heading"}, "speed": 1})";
    return spec;
  }
  explicit Drive(const Binding& binding)
      : speed_(binding.parameters().number("speed")),
        density_(std::pow(binding.parameters().number("noise"), 2)),
        turn_density_(std::pow(binding.parameters().number("turn_noise"), 2)),
        position_(binding.port("position")),
        heading_(binding.port("heading")),
        phi_(declaration_.couples(position_, heading_)),
        q_(declaration_.adds_noise(position_, position_, Structure::diagonal)),
        q_turn_(declaration_.adds_noise(heading_, heading_, Structure::diagonal)) {}
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const double way = speed_ * in.step.dt, psi = in.x[heading_][0];
    out.x[position_][0] = in.x[position_][0] + way * std::cos(psi);
    out.x[position_][1] = in.x[position_][1] + way * std::sin(psi);
    out.x[heading_][0] = psi;
    if (const BlockView phi = out.phi[phi_]) phi.as<2, 1>() << -way * std::sin(psi), way * std::cos(psi);
    if (const BlockView Q = out.Qd[q_]) Q.diagonal<2>().setConstant(density_ * in.step.dt);
    if (const BlockView Q = out.Qd[q_turn_]) Q.diagonal<1>().setConstant(turn_density_ * in.step.dt);
    return Result::ok();
  }

 private:
  double speed_, density_, turn_density_;
  Port position_, heading_;
  PhiBlock phi_;
  QBlock q_, q_turn_;
};

/// y = x_0 − 2 x_1.
class Mixed : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "mixed";
    spec.summary = "A linear combination.";
    spec.ports = {reads("x", "vector:2:m/s", "what is combined")};
    spec.kind = "vector:1:m/s";
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Mixed(const Binding& binding) : x_(binding.port("x")) {
    declaration_.yields("vector:1:m/s", 1, {{"x", "m/s"}}).reads(x_);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    out.value[0] = in.x[x_][0] - 2 * in.x[x_][1];
    if (const MatrixView J = out.J[x_]) J.as<1, 2>() << 1, -2;
    return Result::ok();
  }

 private:
  Port x_;
};

}  // namespace

BINNACLE_PLUGIN("spin", "1.0.0", registry) {
  registry.add<Spin>();
  registry.add<Drive>();
  registry.add<Mixed>();
}
