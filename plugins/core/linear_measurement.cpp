// SPDX-License-Identifier: Apache-2.0
// A vector, or a linear combination of its components, measured directly.
#include "linear_measurement.hpp"

#include <cmath>

namespace binnacle::core {

namespace {

constexpr int most_rows = 8;
enum Port { x_port, bias_port };

Eigen::MatrixXd observation(const Parameters& parameters, Eigen::Index dof) {
  if (!parameters.has("H")) {
    if (dof > most_rows)
      throw ComponentError("the block has " + std::to_string(dof) + " components, a sample at most " +
                           std::to_string(most_rows) + " fields: choose rows with 'H'");
    return Eigen::MatrixXd::Identity(dof, dof);
  }
  const auto H = parameters.matrix("H");
  if (H.cols() != dof)
    throw ComponentError("H has " + std::to_string(H.cols()) + " columns, the block " + std::to_string(dof) +
                             " components",
                         "/H");
  if (H.rows() < 1 || H.rows() > most_rows)
    throw ComponentError("H has " + std::to_string(H.rows()) + " rows; 1 to " + std::to_string(most_rows) +
                             " are possible",
                         "/H");
  return H;
}

Eigen::VectorXd variances(const Parameters& parameters, Eigen::Index rows) {
  const auto sigma = parameters.vector("sigma");
  if (sigma.size() == 1) return Eigen::VectorXd::Constant(rows, sigma[0] * sigma[0]);
  if (sigma.size() != rows)
    throw ComponentError("sigma has " + std::to_string(sigma.size()) + " elements for " + std::to_string(rows) +
                             " rows",
                         "/sigma");
  return sigma.cwiseAbs2();
}

}  // namespace

ComponentSpec LinearMeasurement::spec() {
  ComponentSpec spec;
  spec.type = "linear_measurement";
  spec.summary = "A vector, or linear combinations of its components, measured directly: z = H x + b + v.";
  spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 4.2";
  spec.parameters = {
      parameter::matrix("H", "1").about("what a row sees of the block, row by row; the identity if absent"),
      parameter::vector("sigma", "@x")
          .above(0)
          .required()
          .about("standard deviation of each row's white noise, a list; one element stands for all rows"),
  };
  spec.ports = {reads("x", "vector:*:*", "the vector that is measured"),
                may_read("bias", "vector:*:*", "b, an additive error of the sensor: a component per row")};
  for (int i = 0; i < most_rows; ++i) {
    FieldSpec field;
    field.name = std::string("z").append(std::to_string(i));
    field.unit = "*";
    field.is_optional = i > 0;
    field.text = "measured value of row " + std::to_string(i) + ", in the unit of the block";
    spec.fields.push_back(std::move(field));
  }
  spec.example = R"json({"channel": "vertical_gyro", "blocks": {"x": "roll_motion"}, "fields": {"z0": "roll"},
    "H": [[1, 0]], "sigma": [0.0087]})json";
  spec.surroundings =
      R"json({"blocks": {"roll_motion": {"type": "vector", "size": 2, "unit": "rad", "sigma": 0.1}}})json";
  return spec;
}

LinearMeasurement::LinearMeasurement(const Binding& binding)
    : H_(observation(binding.parameters(), binding.block("x").dof)),
      variance_(variances(binding.parameters(), H_.rows())),
      has_bias_(binding.is_bound("bias")) {
  const int rows = static_cast<int>(H_.rows());
  for (int i = 0; i < rows; ++i)
    if (!binding.has_field(i))
      throw ComponentError("there are " + std::to_string(rows) + " rows, but the channel carries no field for 'z" +
                               std::to_string(i) + "'",
                           "/fields");
  if (has_bias_ && binding.block("bias").dof != rows)
    throw ComponentError("the bias has " + std::to_string(binding.block("bias").dof) + " components for " +
                             std::to_string(rows) + " rows",
                         "/blocks/bias");
  declaration_.max_rows = rows;
  declaration_.read_ports = {x_port};
  if (has_bias_) declaration_.read_ports.push_back(bias_port);
  ResidualGroup group;
  group.name = "z";
  group.rows = rows;
  group.unit = binding.block("x").components.front().unit;
  group.port = binding.parameters().has("H") ? -1 : x_port;
  declaration_.groups = {std::move(group)};
}

Result LinearMeasurement::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                                    const legacy::Context& /*context*/, std::byte* /*memory*/,
                                    legacy::Linearization& out) const {
  const int rows = static_cast<int>(H_.rows());
  const auto z = vector_at(sample.fields, rows);
  if (!z.allFinite()) return Result::invalid("a measured value is not finite");
  out.rows = rows;
  auto residual = vector_at(out.residual, rows);
  residual = z - H_.lazyProduct(vector_at(x[x_port], static_cast<int>(H_.cols())));
  out.H[0].as() = H_;
  if (has_bias_) {
    residual -= vector_at(x[bias_port], rows);
    out.H[1].as().setIdentity();
  }
  for (int i = 0; i < rows; ++i) out.R(i, i) = variance_[i];
  return Result::ok();
}

}  // namespace binnacle::core
