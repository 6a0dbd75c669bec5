// SPDX-License-Identifier: Apache-2.0
// A slave's attitude held against its master's.
#include "dcm_match.hpp"

#include "strapdown/rotation.hpp"

namespace binnacle::transfer_match {

namespace {

using Eigen::Matrix3d;
using strapdown::dcm_from_quaternion;

FieldSpec angle(std::string name, std::string text) {
  return field::level(std::move(name), "rad").about(std::move(text));
}

}  // namespace

ComponentSpec DcmMatch::spec() {
  ComponentSpec spec;
  spec.type = "dcm_match";
  spec.summary = "Attitude matching of transfer alignment: the direction cosines of the master and the slave.";
  spec.source = "paper 000, equations (3) and (4)";
  spec.parameters = {parameter::vector("sigma", "rad", 3)
                         .above(0)
                         .plausible(1e-7, 0.5)
                         .required()
                         .about("standard deviation of the master's attitude, about north, east, down, at each sample"),
                     parameter::choice("jacobian", {"tangent", "chord"})
                         .defaults("\"tangent\"")
                         .about("point of the linearization: the estimate, or second-order accurate over the whole "
                                "residual, for large initial errors")};
  spec.ports = {reads("attitude", "attitude").about("attitude of the slave (SINS)"),
                reads("mounting", "mounting").about("mounting of the slave in the master's axes")};
  spec.fields = {angle("roll", "roll of the master (MINS)"), angle("pitch", "pitch of the master"),
                 angle("yaw", "yaw of the master, from true north")};
  spec.example = R"json({"channel": "mins", "blocks": {"attitude": "attitude", "mounting": "mounting"},
    "sigma": "0.2 arcmin"})json";
  // Attitudes that agree to some degrees: an arbitrary pair of them is refused.
  spec.surroundings = R"json({"blocks": {
      "attitude": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": 0.5}, "sigma": 0.02},
      "mounting": {"type": "transfer_match/mounting", "init": {"mx": 0.01, "my": -0.02, "mz": 0.03}, "sigma": 0.02}},
    "sample": {"roll": 0.01, "pitch": -0.02, "yaw": 0.48}})json";
  return spec;
}

DcmMatch::DcmMatch(const Binding& binding)
    : attitude_(binding.port("attitude")),
      mounting_(binding.port("mounting")),
      angles_(binding.fields("roll", "pitch", "yaw")),
      is_chord_(binding.parameters().text("jacobian") == "chord"),
      variance_(binding.parameters().vector("sigma").cwiseAbs2()) {
  declaration_.rows(3).reads(attitude_).reads(mounting_).group(rows::of("attitude", attitude_));
}

Result DcmMatch::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const Eigen::Vector3d angles = in.sample[angles_];
  if (!angles.allFinite()) return Result::invalid("an angle of the master is not finite");
  const Matrix3d C_M = dcm_from_quaternion(strapdown::quaternion_from_euler(angles));
  const Matrix3d C_S = dcm_from_quaternion(in.x[attitude_].as<4>());
  const Matrix3d A = C_M * dcm_from_quaternion(in.x[mounting_].as<4>()) * C_S.transpose();
  // tr A = 1 + 2 cos: from a right angle on, the antisymmetric part shrinks again and fits two attitudes.
  const double trace = A.trace();
  if (!(trace > 1.0)) return Result::unsupported("slave and master are more than a right angle from their mounting");
  out.rows = 3;
  out.residual.as<3>() << 0.5 * (A(2, 1) - A(1, 2)), 0.5 * (A(0, 2) - A(2, 0)), 0.5 * (A(1, 0) - A(0, 1));
  out.R.as<3, 3>().diagonal() = variance_;
  if (!out.H) return Result::ok();
  const Matrix3d scaled = 0.5 * trace * Matrix3d::Identity();
  Matrix3d of_attitude = scaled - 0.5 * A.transpose(), of_mounting = scaled - 0.5 * A;
  if (is_chord_)
    for (Matrix3d* H : {&of_attitude, &of_mounting}) *H = 0.5 * (*H + Matrix3d::Identity());
  out.H[attitude_].as<3, 3>() = of_attitude;
  out.H[mounting_].as<3, 3>() = -of_mounting * C_M;
  return Result::ok();
}

}  // namespace binnacle::transfer_match
