// SPDX-License-Identifier: Apache-2.0
// A height alone: a barometer, a tide gauge, a map.
#include "height.hpp"

#include <array>
#include <cmath>

namespace binnacle::aiding {

ComponentSpec Height::spec() {
  ComponentSpec spec;
  spec.type = "height";
  spec.summary =
      "A height without a horizontal position, usually from a barometer; bias and scale factor can be estimated.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 6.2.1 "
      "and "
      "16.2.2";
  spec.parameters = {Deviations::parameter(1, "m", 1e-3, 1e3),
                     parameter::number("reference", "m")
                         .defaults("0")
                         .about("height at which the scale factor has no effect, usually where the bias was set")};
  spec.ports = {
      reads("position", "*")
          .about("position of the sensor (a lever_arm): kind position (height above the ellipsoid), or vector:3:m "
                 "(north, east, down)"),
      reads("bias", "vector:1:m")
          .optional()
          .about("bias of the measured height, positive upwards: weather, geoid, reference"),
      reads("scale", "vector:1:1")
          .optional()
          .about("scale factor error of the height over 'reference', because the air is not a standard atmosphere")};
  spec.fields = {field::level("height", "m").about("height, upwards positive"), Deviations::field("height", "m")};
  spec.example = R"json({"channel": "barometer", "blocks": {"position": "position", "bias": "baro_bias",
    "scale": "baro_scale"}, "sigma": "0.3 m", "reference": "60 m", "gate": 0.999})json";
  spec.surroundings = R"json({"blocks": {
    "position": {"type": "navigation/position", "init": {"lat": "37.4 deg", "lon": "126.9 deg", "height": "160 m"}, "sigma": 3},
    "baro_bias": {"type": "vector", "size": 1, "unit": "m", "init": 2, "sigma": 5},
    "baro_scale": {"type": "vector", "size": 1, "unit": "1", "init": 0.01, "sigma": 0.02}},
    "sample": {"height": 163, "height_sd": 0.5}})json";
  return spec;
}

Height::Height(const Binding& binding)
    : position_(binding.port("position")),
      bias_(binding.port("bias")),
      scale_(binding.port("scale")),
      height_(binding.field("height")),
      sigma_(binding, std::array{"height"}),
      reference_(binding.parameters().number("reference")),
      upward_(binding.block("position").kind == "position" ? 1 : -1) {
  const std::string& kind = binding.block("position").kind;
  if (kind != "position" && kind != "vector:3:m")
    throw ComponentError("a position is of the kind 'position' or 'vector:3:m'; found '" + kind +
                             "' (of ECEF blocks gnss_range/geodetic_position makes one)",
                         "/blocks/position");
  declaration_.rows(1).reads(position_).reads(bias_).reads(scale_).group(rows::these("height", 1, "m"));
}

Result Height::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const double z = in.sample[height_];
  if (!std::isfinite(z)) return Result::invalid("the height is not finite");
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  const double height = upward_ * in.x[position_][2];
  const double bias = bias_.is_bound() ? in.x[bias_][0] : 0, scale = scale_.is_bound() ? in.x[scale_][0] : 0;
  out.rows = 1;
  out.residual[0] = z - (height + bias + scale * (height - reference_));
  if (const MatrixView H = out.H[position_]) H(0, 2) = -(1 + scale);
  if (const MatrixView H = out.H[bias_]) H(0, 0) = 1;
  if (const MatrixView H = out.H[scale_]) H(0, 0) = height - reference_;
  return Result::ok();
}

}  // namespace binnacle::aiding
