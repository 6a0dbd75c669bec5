// SPDX-License-Identifier: Apache-2.0
// An attitude that another system gives.
#include "attitude_fix.hpp"

#include <array>
#include <cmath>
#include <string>

#include <Eigen/LU>

#include "strapdown/rotation.hpp"

namespace binnacle::aiding {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double rounding = 1e-2;  // of printed digits: beyond it a quaternion or a matrix is no rotation

FieldSpec optional(std::string name, const char* unit, const char* text) {
  return field::level(std::move(name), unit).optional().about(text);
}

}  // namespace

ComponentSpec AttitudeFix::spec() {
  ComponentSpec spec;
  spec.type = "attitude_fix";
  spec.summary = "An attitude from another system, as a quaternion, a matrix, or roll, pitch and yaw.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 2.2 and "
      "6.1";
  spec.parameters = {Deviations::parameter(3, "rad", 1e-6, 1),
                     parameter::choice("form", {"quaternion", "dcm", "angles"})
                         .about("form of the attitude; default: the form that the channel carries")};
  spec.ports = {
      reads("attitude", "attitude").about("attitude of the body, or a mounted_attitude of the other system's axes")};
  for (const char* name : {"qw", "qx", "qy", "qz"})
    spec.fields.push_back(optional(name, "1", "quaternion, body (forward, right, down) to north, east, down"));
  for (const char* row : {"1", "2", "3"})
    for (const char* col : {"1", "2", "3"})
      spec.fields.push_back(
          optional(std::string("c") + row + col, "1", "element of C_nb: row north, east or down, column x, y or z"));
  spec.fields.push_back(optional("roll", "rad", "roll, right side down positive"));
  spec.fields.push_back(optional("pitch", "rad", "pitch, nose up positive"));
  spec.fields.push_back(optional("yaw", "rad", "yaw, clockwise from true north"));
  for (const char* axis : {"north", "east", "down"}) spec.fields.push_back(Deviations::field(axis, "rad"));
  spec.example = R"json({"channel": "star_tracker", "blocks": {"attitude": "attitude"}, "form": "angles",
    "sigma": ["0.1 deg", "0.1 deg", "0.3 deg"], "gate": 0.999})json";
  spec.surroundings = R"json({"blocks": {
    "attitude": {"type": "navigation/attitude", "init": {"roll": 0.1, "pitch": -0.2, "yaw": 3.13}, "sigma": 0.02}},
    "sample": {"roll": 0.11, "pitch": -0.19, "yaw": -3.14, "north_sd": 0.002, "east_sd": 0.002, "down_sd": 0.005}})json";
  return spec;
}

AttitudeFix::AttitudeFix(const Binding& binding)
    : attitude_(binding.port("attitude")),
      quaternion_(binding.fields("qw", "qx", "qy", "qz")),
      dcm_(binding.fields("c11", "c12", "c13", "c21", "c22", "c23", "c31", "c32", "c33")),
      angles_(binding.fields("roll", "pitch", "yaw")),
      sigma_(binding, std::array{"north", "east", "down"}) {
  struct Choice {
    Form form;
    const char* name;
    const char* fields;
    bool is_carried;
  };
  const std::array<Choice, 3> choices = {{{Form::quaternion, "quaternion", "'qw' to 'qz'", quaternion_.is_bound()},
                                          {Form::dcm, "dcm", "'c11' to 'c33'", dcm_.is_bound()},
                                          {Form::angles, "angles", "'roll', 'pitch', 'yaw'", angles_.is_bound()}}};
  const bool is_stated = binding.parameters().has("form");
  int carried = 0;
  for (const Choice& choice : choices) {
    if (is_stated ? binding.parameters().text("form") != choice.name : !choice.is_carried) continue;
    if (!choice.is_carried)
      throw ComponentError(std::string("the channel does not carry all of ") + choice.fields, "/form");
    form_ = choice.form;
    ++carried;
  }
  if (carried == 0)
    throw ComponentError("the channel carries no attitude: 'qw' to 'qz', 'c11' to 'c33', or 'roll', 'pitch', 'yaw'",
                         "/fields");
  if (carried > 1) throw ComponentError("the channel carries an attitude in more than one form: state \"form\"", "");
  declaration_.rows(3).reads(attitude_).group(rows::of("attitude", attitude_));
}

const char* AttitudeFix::read(const SampleView& sample, Vector4d& q_nb) const {
  if (form_ == Form::angles) {
    const Vector3d angles = sample[angles_];
    if (!angles.allFinite()) return "an angle is not finite";
    q_nb = strapdown::quaternion_from_euler(angles);
  } else if (form_ == Form::quaternion) {
    q_nb = sample[quaternion_];
    if (!(std::abs(q_nb.norm() - 1) < rounding)) return "the quaternion is not of length 1";
    q_nb.normalize();
  } else {
    const Eigen::Matrix<double, 9, 1> elements = sample[dcm_];
    const Matrix3d C = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(elements.data());
    if (!((C * C.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() < rounding) || !(C.determinant() > 0))
      return "the matrix is not a rotation";
    q_nb = strapdown::quaternion_from_dcm(C).normalized();
  }
  return nullptr;
}

Result AttitudeFix::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  Vector4d q_z;
  if (const char* const flaw = read(in.sample, q_z)) return Result::invalid(flaw);
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  const Vector3d r = strapdown::attitude_minus(q_z, in.x[attitude_].as<4>());
  out.rows = 3;
  out.residual.as<3>() = r;
  if (const MatrixView H = out.H[attitude_]) H.as<3, 3>() = strapdown::left_jacobian_inverse(-r);
  return Result::ok();
}

}  // namespace binnacle::aiding
