// SPDX-License-Identifier: Apache-2.0
// Non-holonomic constraint: wheels roll forward, and neither sideways nor off the road.
#include "nhc.hpp"

#include <cmath>

namespace binnacle::land {

namespace {

FieldSpec rate(std::string name) {
  return field::rate(std::move(name), "rad/s").optional().about("angular rate; for 'slip', 'turn' and 'max_turn_rate'");
}

FieldSpec lateral_force() {
  return field::rate("fy", "m/s^2").optional().about("specific force to the right of the vehicle; for 'lateral'");
}

FieldSpec mean_force(std::string name, std::string about) {
  return field::rate(std::move(name), "m/s^2").optional().about("mean specific force " + about + "; for 'compliance'");
}

double squared(double value) { return value * value; }

}  // namespace

ComponentSpec Nhc::spec() {
  ComponentSpec spec;
  spec.type = "nhc";
  spec.summary = "Non-holonomic constraint: a wheeled vehicle moves only along its x axis.";
  spec.source = "paper 001, equations (4) and (9)";
  spec.parameters = {
      parameter::vector("sigma", "m/s", 2)
          .above(0)
          .plausible(1e-4, 10)
          .required()
          .about("standard deviation of the true velocity to the right (y) and down (z)"),
      parameter::choice("axes", {"yz", "y", "z"}).defaults("\"yz\"").about("constrained axes"),
      parameter::number("angle", "rad")
          .at_least(0)
          .plausible(0, 0.5)
          .defaults("0")
          .about("angle between the direction of travel and x, 1-sigma; adds (angle * speed)^2 to both variances"),
      parameter::number("slip", "rad*s^2/m")
          .at_least(0)
          .defaults("0")
          .about("side-slip per lateral acceleration; adds (slip * |w| * speed^2)^2 to the variance of y"),
      parameter::number("turn", "m")
          .at_least(0)
          .plausible(0, 10)
          .defaults("0")
          .about("uncertainty of the point's position; adds (turn * |w|)^2 to both variances"),
      parameter::number("lateral", "s")
          .at_least(0)
          .plausible(0, 1)
          .defaults("0")
          .about("lateral velocity per lateral specific force; adds (lateral * fy)^2 to the variance of y"),
      parameter::number("min_speed", "m/s")
          .at_least(0)
          .defaults("2")
          .about("least speed; samples at lower speeds are unsupported"),
      parameter::number("max_turn_rate", "rad/s")
          .above(0)
          .about("largest turn rate; samples at higher rates are unsupported"),
      Spacing::parameter()};
  spec.ports = vehicle_ports();
  spec.ports.push_back(
      reads("compliance", "vector:2:rad*s^2/m")
          .optional()
          .about("y: side-slip per specific force to the right, z: pitch of the body on its springs per "
                 "specific force ahead; negative and positive for a car"));
  spec.fields = {mean_force("fy", "to the right"), mean_force("fx", "ahead")};
  spec.driving_rates = {rate("wx"), rate("wy"), rate("wz"), lateral_force()};
  spec.example = R"json({"channel": "motion.moving", "blocks": {"velocity": "velocity", "attitude": "attitude",
    "misalignment": "misalignment", "compliance": "compliance"}, "sigma": "0.2 m/s"})json";
  spec.surroundings = R"json({"blocks": {
      "velocity": {"type": "navigation/velocity", "init": {"vn": 12, "ve": -9, "vd": 0.3}, "sigma": 0.3},
      "attitude": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": -0.6}, "sigma": 0.02},
      "misalignment": {"type": "core/vector", "size": 3, "unit": "rad", "init": {"x": 0, "y": -0.01, "z": 0.02}, "sigma": 0.03},
      "compliance": {"type": "core/vector", "size": 2, "unit": "rad*s^2/m", "init": {"x0": -0.007, "x1": 0.004}, "sigma": 0.01}}})json";
  return spec;
}

Nhc::Nhc(const Binding& binding)
    : velocity_(binding, declaration_),
      compliance_(binding.port("compliance")),
      spacing_(binding, declaration_),
      omega_(binding.driving_rates("wx", "wy", "wz")),
      force_(binding.driving_rate("fy")),
      forces_(binding.fields("fy", "fx")),
      sigma_(binding.parameters().vector("sigma")),
      angle_(binding.parameters().number("angle")),
      slip_(binding.parameters().number("slip")),
      turn_(binding.parameters().number("turn")),
      lateral_(binding.parameters().number("lateral")),
      min_speed_(binding.parameters().number("min_speed")) {
  const std::string& axes = binding.parameters().text("axes");
  first_ = axes == "z" ? 1 : 0;
  rows_ = axes == "yz" ? 2 : 1;
  if (binding.parameters().has("max_turn_rate")) max_turn_rate_ = binding.parameters().number("max_turn_rate");
  if (compliance_.is_bound() && !forces_.is_bound())
    throw ComponentError(
        "a compliance needs the specific force of the samples, 'fx' and 'fy', which a stationary_detector's "
        "channels have",
        "/blocks/compliance");
  declaration_.rows(rows_).reads(compliance_).group(rows::these("across", rows_, "m/s"));
}

/// Of y and z, by how the vehicle moves just now: no residual is asked, whose large ones come in curves and would teach R
/// only when they are over.
Result Nhc::vary(const MeasurementInput& in, double speed, Eigen::Vector2d& variance) const {
  double turn_rate = 0, force = 0;
  if (slip_ > 0 || turn_ > 0 || max_turn_rate_) {
    if (!in.u.rates || !in.u.rates[omega_].allFinite()) return Result::unsupported("the angular rate is not known");
    turn_rate = in.u.rates[omega_].norm();
    if (max_turn_rate_ && turn_rate > *max_turn_rate_)
      return Result::unsupported("turning faster than 'max_turn_rate'");
  }
  if (lateral_ > 0) {
    if (!in.u.rates || !std::isfinite(in.u.rates[force_]))
      return Result::unsupported("the specific force is not known");
    force = in.u.rates[force_];
  }
  variance = sigma_.cwiseAbs2().array() + squared(angle_ * speed) + squared(turn_ * turn_rate);
  variance[0] += squared(slip_ * turn_rate * squared(speed)) + squared(lateral_ * force);
  return Result::ok();
}

Result Nhc::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  if (const Result result = spacing_.pass(in); !result) return result;
  const auto value = velocity_.at(in.x);
  const double speed = value.v_v.norm();
  if (!(speed >= min_speed_)) return Result::unsupported("slower than 'min_speed'");
  Eigen::Vector2d variance;
  if (const Result result = vary(in, speed, variance); !result) return result;
  Eigen::Vector2d force = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> yz;
  yz << 0, 1, 0, 0, 0, 1;
  if (compliance_.is_bound()) {
    force = in.sample[forces_];
    if (!force.allFinite()) return Result::invalid("the specific force is not finite");
    yz.col(0) = -force.cwiseProduct(in.x[compliance_].as<2>());
  }
  out.rows = rows_;
  for (int row = 0; row < rows_; ++row) {
    out.residual[row] = -yz.row(first_ + row).dot(value.v_v);
    out.R(row, row) = variance[first_ + row];
    if (const MatrixView H = out.H[compliance_]) H(row, first_ + row) = -force[first_ + row] * value.v_v[0];
  }
  if (rows_ == 2)
    velocity_.write_jacobians(value, yz, out.H);
  else
    velocity_.write_jacobians(value, Eigen::RowVector3d(yz.row(first_)), out.H);
  return Result::ok();
}

}  // namespace binnacle::land
