// SPDX-License-Identifier: Apache-2.0
#include "gyro.hpp"

#include <cmath>

namespace binnacle::ship_motion {

namespace {

constexpr const char* error_suffix = "_error";

/// Ports come in pairs, an axis and its error; a field has the name of its axis.
ComponentSpec gyro_spec(const char* type, const char* summary, const std::vector<std::string>& axes, const char* unit) {
  ComponentSpec spec;
  spec.type = type;
  spec.summary = summary;
  spec.source = "paper 004, sections 1 and 3";
  spec.parameters = {
      parameter::number("sigma", unit).above(0).required().about("standard deviation of the white noise of each axis")};
  const std::string kind = std::string("vector:1:") + unit;
  for (const auto& axis : axes) {
    spec.ports.push_back(reads(axis, kind).optional().about(axis + " of the ship"));
    spec.ports.push_back(reads(axis + error_suffix, kind).optional().about("what the gyro's drift adds to " + axis));
    spec.fields.push_back(field::level(axis, unit).optional().about(axis + " as measured"));
  }
  const std::string& axis = axes.front();
  spec.example = R"json({"channel": "gyro", "blocks": {")json" + axis + R"json(": "motion", ")json" + axis +
                 error_suffix + R"json(": "drift_angle"}, "sigma": 0.0087})json";
  spec.surroundings = R"json({"blocks": {"motion": {"type": "vector", "size": 1, "unit": ")json" + std::string(unit) +
                      R"json(", "sigma": 0.02}, "drift_angle": {"type": "vector", "size": 1, "unit": ")json" + unit +
                      R"json(", "sigma": 0.001}}})json";
  return spec;
}

}  // namespace

ComponentSpec VerticalGyro::spec() {
  return gyro_spec("vertical_gyro", "Roll and pitch from a vertical gyro: angle, drift, noise.", {"roll", "pitch"},
                   "rad");
}

ComponentSpec DirectionalGyro::spec() {
  return gyro_spec("directional_gyro", "Roll and yaw from a directional gyro: angle, drift, noise.", {"roll", "yaw"},
                   "rad");
}

ComponentSpec RateGyro::spec() {
  return gyro_spec("rate_gyro", "Rates of the ship's angles from rate gyros: rate, drift, noise.",
                   {"roll_rate", "pitch_rate", "yaw_rate"}, "rad/s");
}

Gyro::Gyro(const Binding& binding) {
  const double sigma = binding.parameters().number("sigma");
  variance_ = sigma * sigma;
  for (const PortBinding& block : binding.ports()) {
    if (block.name.ends_with(error_suffix)) continue;
    const std::string error_name = block.name + error_suffix;
    const Axis axis{binding.field(block.name), binding.port(block.name), binding.port(error_name)};
    if (!axis.x.is_bound()) {
      if (axis.error.is_bound())
        throw ComponentError("'" + error_name + "' is an error of '" + block.name + "', which is not bound",
                             "/blocks/" + error_name);
      continue;
    }
    if (!axis.z.is_bound()) throw ComponentError("the channel carries no field for '" + block.name + "'", "/fields");
    declaration_.reads(axis.x).reads(axis.error).group(rows::of(block.name, axis.x));
    axes_.push_back(axis);
  }
  if (axes_.empty()) throw ComponentError("bind at least one axis of the gyro", "/blocks");
  declaration_.rows(static_cast<int>(axes_.size()));
}

Result Gyro::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  out.rows = static_cast<int>(axes_.size());
  for (int row = 0; row < out.rows; ++row) {
    const Axis& axis = axes_[static_cast<std::size_t>(row)];
    const double z = in.sample[axis.z];
    if (!std::isfinite(z)) return Result::invalid("a measured value is not finite");
    out.residual[row] = z - in.x[axis.x][0];
    if (axis.error.is_bound()) out.residual[row] -= in.x[axis.error][0];
    if (const MatrixView H = out.H[axis.x]) H(row, 0) = 1;
    if (const MatrixView H = out.H[axis.error]) H(row, 0) = 1;
    out.R(row, row) = variance_;
  }
  return Result::ok();
}

}  // namespace binnacle::ship_motion
