// SPDX-License-Identifier: Apache-2.0
// A vector, or a linear combination of its components, measured directly.
#include "linear_measurement.hpp"

namespace binnacle::core {

namespace {

constexpr int most_rows = 8;

std::string name_of_row(int i) { return std::string("z").append(std::to_string(i)); }

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
      parameter::matrix("H", "1").about("observation matrix, row by row; default: the identity"),
      parameter::vector("sigma", "@x")
          .above(0)
          .required()
          .about("standard deviation of each row's white noise, as a list; one element applies to all rows"),
  };
  spec.ports = {reads("x", "vector:*:*").about("the vector that is measured"),
                reads("bias", "vector:*:*").optional().about("additive error b of the sensor, a component per row")};
  for (int i = 0; i < most_rows; ++i) {
    FieldSpec z = field::level(name_of_row(i), "*")
                      .about("measured value of row " + std::to_string(i) + ", in the unit of the block");
    z.is_optional = i > 0;
    spec.fields.push_back(std::move(z));
  }
  spec.example = R"json({"channel": "vertical_gyro", "blocks": {"x": "roll_motion"}, "fields": {"z0": "roll"},
    "H": [[1, 0]], "sigma": [0.0087]})json";
  spec.surroundings =
      R"json({"blocks": {"roll_motion": {"type": "vector", "size": 2, "unit": "rad", "sigma": 0.1}}})json";
  return spec;
}

LinearMeasurement::LinearMeasurement(const Binding& binding)
    : x_(binding.port("x")),
      bias_(binding.port("bias")),
      H_(observation(binding.parameters(), x_.dof())),
      variance_(variances(binding.parameters(), H_.rows())) {
  const int rows = static_cast<int>(H_.rows());
  for (int i = 0; i < rows; ++i) {
    z_.push_back(binding.field(name_of_row(i)));
    if (!z_.back().is_bound())
      throw ComponentError("there are " + std::to_string(rows) + " rows, but the channel carries no field for '" +
                               name_of_row(i) + "'",
                           "/fields");
  }
  if (bias_.is_bound() && bias_.dof() != rows)
    throw ComponentError("the bias has " + std::to_string(bias_.dof()) + " components for " + std::to_string(rows) +
                             " rows",
                         "/blocks/bias");
  const std::string& unit = binding.block("x").components.front().unit;
  declaration_.rows(rows).reads(x_).reads(bias_).group(binding.parameters().has("H") ? rows::these("z", rows, unit)
                                                                                     : rows::of("z", x_));
}

Result LinearMeasurement::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  out.rows = static_cast<int>(H_.rows());
  auto residual = out.residual.as();
  for (int i = 0; i < out.rows; ++i) residual[i] = in.sample[z_[static_cast<std::size_t>(i)]];
  if (!residual.allFinite()) return Result::invalid("a measured value is not finite");
  residual -= H_.lazyProduct(in.x[x_].as());
  if (bias_.is_bound()) residual -= in.x[bias_].as();
  if (const MatrixView H = out.H[x_]) H.as() = H_;
  if (const MatrixView H = out.H[bias_]) H.as().setIdentity();
  for (int i = 0; i < out.rows; ++i) out.R(i, i) = variance_[i];
  return Result::ok();
}

}  // namespace binnacle::core
