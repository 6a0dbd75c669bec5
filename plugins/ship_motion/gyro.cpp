// SPDX-License-Identifier: Apache-2.0
#include "gyro.hpp"

#include <cmath>

namespace binnacle::ship_motion {

namespace {

/// Ports come in pairs, an axis and its error, in the order of the fields.
ComponentSpec gyro_spec(const char* type, const char* summary, const std::vector<std::string>& axes, const char* unit) {
  ComponentSpec spec;
  spec.type = type;
  spec.summary = summary;
  spec.source = "paper 004, sections 1 and 3";
  spec.parameters = {
      parameter::number("sigma", unit).above(0).required().about("standard deviation of the white noise of each axis")};
  const std::string kind = std::string("vector:1:") + unit;
  for (const auto& axis : axes) {
    spec.ports.push_back(may_read(axis, kind, axis + " of the ship"));
    spec.ports.push_back(may_read(axis + "_error", kind, "what the gyro's drift adds to " + axis));
    FieldSpec field;
    field.name = axis;
    field.unit = unit;
    field.is_optional = true;
    field.text = axis + " as measured";
    spec.fields.push_back(std::move(field));
  }
  const std::string& axis = axes.front();
  spec.example = R"json({"channel": "gyro", "blocks": {")json" + axis + R"json(": "motion", ")json" + axis +
                 R"json(_error": "drift_angle"}, "sigma": 0.0087})json";
  spec.surroundings = R"json({"blocks": {"motion": {"type": "vector", "size": 1, "unit": ")json" + std::string(unit) +
                      R"json(", "sigma": 0.02}, "drift_angle": {"type": "vector", "size": 1, "unit": ")json" + unit +
                      R"json(", "sigma": 0.001}}})json";
  return spec;
}

}  // namespace

ComponentSpec VerticalGyro::spec() {
  return gyro_spec("vertical_gyro", "Roll and pitch as a vertical gyro reads them: angle, drift, noise.",
                   {"roll", "pitch"}, "rad");
}

ComponentSpec DirectionalGyro::spec() {
  return gyro_spec("directional_gyro", "Roll and yaw as a directional gyro reads them: angle, drift, noise.",
                   {"roll", "yaw"}, "rad");
}

ComponentSpec RateGyro::spec() {
  return gyro_spec("rate_gyro", "Rates of the ship's angles as rate gyros read them: rate, drift, noise.",
                   {"roll_rate", "pitch_rate", "yaw_rate"}, "rad/s");
}

Gyro::Gyro(const Binding& binding) {
  const double sigma = binding.parameters().number("sigma");
  variance_ = sigma * sigma;
  const auto& ports = binding.ports();
  for (int field = 0; 2 * field < static_cast<int>(ports.size()); ++field) {
    const int port = 2 * field, error_port = port + 1;
    const auto& axis = ports[static_cast<std::size_t>(port)];
    const auto& error = ports[static_cast<std::size_t>(error_port)];
    if (!axis.bound) {
      if (error.bound)
        throw ComponentError("'" + error.name + "' is an error of '" + axis.name + "', which is not bound",
                             "/blocks/" + error.name);
      continue;
    }
    if (!binding.has_field(field))
      throw ComponentError("the channel carries no field for '" + axis.name + "'", "/fields");
    Axis entry;
    entry.field = field;
    entry.port = port;
    entry.jacobian = static_cast<int>(declaration_.read_ports.size());
    declaration_.read_ports.push_back(port);
    if (error.bound) {
      entry.error_port = error_port;
      entry.error_jacobian = static_cast<int>(declaration_.read_ports.size());
      declaration_.read_ports.push_back(error_port);
    }
    ResidualGroup group;
    group.name = axis.name;
    group.first_row = static_cast<int>(axes_.size());
    group.rows = 1;
    group.unit = axis.components.front().unit;
    group.port = port;
    declaration_.groups.push_back(std::move(group));
    axes_.push_back(entry);
  }
  if (axes_.empty()) throw ComponentError("a gyro measures something: bind one of its axes", "/blocks");
  declaration_.max_rows = static_cast<int>(axes_.size());
}

Result Gyro::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                       const legacy::Context& /*context*/, std::byte* /*memory*/, legacy::Linearization& out) const {
  out.rows = static_cast<int>(axes_.size());
  for (int row = 0; row < out.rows; ++row) {
    const Axis& axis = axes_[static_cast<std::size_t>(row)];
    const double z = sample.fields[axis.field];
    if (!std::isfinite(z)) return Result::invalid("a measured value is not finite");
    out.residual[row] = z - x[axis.port][0];
    out.H[axis.jacobian](row, 0) = 1;
    if (axis.error_port >= 0) {
      out.residual[row] -= x[axis.error_port][0];
      out.H[axis.error_jacobian](row, 0) = 1;
    }
    out.R(row, row) = variance_;
  }
  return Result::ok();
}

}  // namespace binnacle::ship_motion
