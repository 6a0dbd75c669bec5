// SPDX-License-Identifier: Apache-2.0
// The earth's magnetic field in body axes.
#include "magnetometer.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "strapdown/rotation.hpp"

namespace binnacle::aiding {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Where the elements of ΔS stand: {row, column} of component i, and of a symmetric one's other place.
constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

std::vector<ParameterSpec> magnetometer_parameters() {
  using namespace parameter;
  return {Deviations::parameter(3, "T", 1e-10, 1e-4),
          number("declination", "rad")
              .at_least(-std::numbers::pi)
              .at_most(std::numbers::pi)
              .about("declination of the field, from true north to the east; with 'inclination' and 'strength'"),
          number("inclination", "rad")
              .at_least(-std::numbers::pi / 2)
              .at_most(std::numbers::pi / 2)
              .about("inclination of the field below the horizon, positive in the northern hemisphere"),
          number("strength", "T")
              .above(0)
              .plausible(1e-6, 1e-3)
              .about("magnetic flux density of the field: 22 to 67 uT on the earth"),
          vector("field", "T", 3)
              .plausible(1e-8, 1e-3)
              .about("north, east and down components of the field, instead of declination, inclination and strength"),
          vector("hard_iron", "T", 3)
              .defaults("[0, 0, 0]")
              .about("hard iron: field of the body's own magnets from a calibration, body axes"),
          matrix("soft_iron", "1", 3, 3)
              .defaults("[[1, 0, 0], [0, 1, 0], [0, 0, 1]]")
              .about(
                  "soft iron: matrix S0 from a calibration, which maps the true to the measured field in body axes")};
}

Vector3d field_of(const Binding& binding, bool is_given) {
  const Parameters& parameters = binding.parameters();
  const bool by_angles = parameters.has("declination") || parameters.has("inclination") || parameters.has("strength");
  if (parameters.has("field") + by_angles + is_given > 1)
    throw ComponentError(
        "the field is given more than once: 'field', or 'declination', 'inclination' and 'strength', or "
        "the input 'field'",
        parameters.has("field") ? "/field" : "");
  if (parameters.has("field")) return parameters.vector("field");
  if (is_given) return Vector3d::Zero();
  for (const char* name : {"declination", "inclination", "strength"})
    if (!parameters.has(name))
      throw ComponentError(std::string("missing key '") + name +
                               "': the field is 'declination', 'inclination' and 'strength', or 'field' (north, east, "
                               "down), or a channel on the input 'field'",
                           "");
  const double D = parameters.number("declination"), I = parameters.number("inclination");
  return parameters.number("strength") * Vector3d(std::cos(I) * std::cos(D), std::cos(I) * std::sin(D), std::sin(I));
}

}  // namespace

ComponentSpec Magnetometer::spec() {
  ComponentSpec spec;
  spec.type = "magnetometer";
  spec.summary = "Three axes of the earth's magnetic field; hard and soft iron errors can be estimated.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 6.1.1";
  spec.parameters = magnetometer_parameters();
  spec.ports = {
      reads("attitude", "attitude").about("attitude of the body, or a mounted_attitude of the sensor"),
      reads("hard_iron", "vector:3:T").optional().about("estimated hard iron error, added to the parameter, body axes"),
      reads("soft_iron", "vector:*:1")
          .optional()
          .about("estimated soft iron error, added to the parameter: xx yy zz, or xx yy zz xy xz yz (symmetric), or "
                 "nine row by row")};
  spec.fields = {field::level("mx", "T").about("magnetic flux density along x, forward"),
                 field::level("my", "T").about("magnetic flux density along y, right"),
                 field::level("mz", "T").about("magnetic flux density along z, down")};
  for (const char* name : {"mx", "my", "mz"}) spec.fields.push_back(Deviations::field(name, "T"));
  spec.inputs = {input("field", {field::level("north", "T").about("north component of the field"),
                                 field::level("east", "T").about("east component of the field"),
                                 field::level("down", "T").about("down component of the field")})
                     .optional()
                     .about("magnetic field at the vehicle, from a map or a model")};
  spec.example = R"json({"channel": "compass", "blocks": {"attitude": "attitude", "hard_iron": "hard_iron",
    "soft_iron": "soft_iron"}, "declination": "3.5 deg", "inclination": "64 deg", "strength": "48 uT", "sigma": "0.25 uT",
    "gate": 0.999})json";
  spec.surroundings = R"json({"blocks": {
    "attitude": {"type": "navigation/attitude", "init": {"roll": 0.1, "pitch": -0.2, "yaw": 2.0}, "sigma": 0.02},
    "hard_iron": {"type": "vector", "size": 3, "unit": "T", "init": [1e-6, -2e-6, 1.5e-6], "sigma": 2e-6},
    "soft_iron": {"type": "vector", "size": 6, "unit": "1", "init": [0.01, -0.02, 0.015, 0.01, -0.005, 0.003], "sigma": 0.02}},
    "sample": {"mx": 5e-6, "my": -18e-6, "mz": 43e-6, "mx_sd": 3e-7, "my_sd": 3e-7, "mz_sd": 3e-7}})json";
  return spec;
}

Magnetometer::Magnetometer(const Binding& binding)
    : attitude_(binding.port("attitude")),
      hard_iron_(binding.port("hard_iron")),
      soft_iron_(binding.port("soft_iron")),
      z_(binding.fields("mx", "my", "mz")),
      input_(binding.input("field")),
      sigma_(binding, std::array{"mx", "my", "mz"}),
      field_n_(field_of(binding, input_.is_bound())),
      fixed_hard_iron_(binding.parameters().vector("hard_iron")),
      fixed_soft_iron_(binding.parameters().matrix("soft_iron")) {
  given_field_ = binding.fields(input_, "north", "east", "down");
  const int dof = soft_iron_.dof();
  if (soft_iron_.is_bound() && dof != 3 && dof != 6 && dof != 9)
    throw ComponentError("soft iron has 3 components (xx yy zz), 6 (xx yy zz xy xz yz) or 9 (row by row); found " +
                             std::to_string(dof),
                         "/blocks/soft_iron");
  declaration_.rows(3).reads(attitude_).reads(hard_iron_).reads(soft_iron_).group(rows::these("field", 3, "T"));
}

Matrix3d Magnetometer::soft_iron(const PortValues& x) const {
  Matrix3d S = fixed_soft_iron_;
  const int dof = soft_iron_.dof();
  for (int i = 0; i < dof; ++i) {
    const double s = x[soft_iron_][i];
    const int row = dof == 9 ? i / 3 : pairs[i][0], col = dof == 9 ? i % 3 : pairs[i][1];
    S(row, col) += s;
    if (dof == 6 && row != col) S(col, row) += s;
  }
  return S;
}

void Magnetometer::write_soft_iron(const Vector3d& m_b, const MatrixView& H) const {
  const int dof = soft_iron_.dof();
  for (int i = 0; i < dof; ++i) {
    const int row = dof == 9 ? i / 3 : pairs[i][0], col = dof == 9 ? i % 3 : pairs[i][1];
    H(row, i) = m_b[col];
    if (dof == 6 && row != col) H(col, i) = m_b[row];
  }
}

Result Magnetometer::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const Vector3d z = in.sample[z_];
  if (!z.allFinite()) return Result::invalid("the field is not finite");
  Vector3d m_n = field_n_;
  if (input_.is_bound()) {
    const SampleView& given = in.auxiliary[input_];
    if (!given.available) return Result::unsupported("the input 'field' has given nothing yet");
    m_n = given[given_field_];
    if (!m_n.allFinite()) return Result::invalid("the field of the input is not finite");
  }
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  const Matrix3d C_bn = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>()).transpose(), S = soft_iron(in.x);
  const Vector3d m_b = C_bn * m_n;
  Vector3d h = fixed_hard_iron_;
  if (hard_iron_.is_bound()) h += in.x[hard_iron_].as<3>();
  out.rows = 3;
  out.residual.as<3>() = z - (S * m_b + h);
  if (const MatrixView H = out.H[attitude_]) H.as<3, 3>() = S * C_bn * strapdown::skew(m_n);
  if (const MatrixView H = out.H[hard_iron_]) H.as<3, 3>().setIdentity();
  if (const MatrixView H = out.H[soft_iron_]) write_soft_iron(m_b, H);
  return Result::ok();
}

}  // namespace binnacle::aiding
