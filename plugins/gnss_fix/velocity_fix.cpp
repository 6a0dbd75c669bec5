// SPDX-License-Identifier: Apache-2.0
// A velocity as a receiver computes it.
#include "velocity_fix.hpp"

namespace binnacle::gnss_fix {

namespace {

constexpr int first_sigma = 3;  // after vn, ve, vd

}  // namespace

ComponentSpec VelocityFix::spec() {
  ComponentSpec spec;
  spec.type = "velocity_fix";
  spec.summary = "A velocity over ground from a receiver, with its own standard deviations where it has them.";
  spec.source = "paper 003, equation (11)";
  spec.parameters = ReportedSigma::parameters("m/s");
  spec.ports = {reads("velocity", "velocity.ned", "of the antenna: a velocity block, or a lever_arm_velocity")};
  spec.fields = {{"vn", "m/s", FieldKind::level, false, false, "velocity over ground, north"},
                 {"ve", "m/s", FieldKind::level, false, false, "velocity over ground, east"},
                 {"vd", "m/s", FieldKind::level, false, false, "velocity over ground, down"}};
  for (FieldSpec& field : ReportedSigma::fields("velocity_sd", "m/s")) spec.fields.push_back(std::move(field));
  spec.example = R"json({"channel": "gnss", "blocks": {"velocity": "velocity"}, "sigma": "0.1 m/s",
    "floor": "0.03 m/s", "gate": 0.999})json";
  return spec;
}

VelocityFix::VelocityFix(const Binding& binding) : sigma_(binding, first_sigma) {
  declaration_.max_rows = 3;
  declaration_.read_ports = {0};
  declaration_.groups = {{"velocity", 0, 3, "m/s", 0}};
}

Result VelocityFix::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                              const legacy::Context& /*context*/, std::byte* /*memory*/,
                              legacy::Linearization& out) const {
  const auto z = vector_at<3>(sample.fields);
  if (!z.allFinite()) return Result::invalid("a velocity is not finite");
  if (const Result result = sigma_.write_variances(sample.fields, out.R); !result) return result;
  out.rows = 3;
  vector_at<3>(out.residual) = z - vector_at<3>(x[0]);
  out.H[0].as<3, 3>().setIdentity();
  return Result::ok();
}

}  // namespace binnacle::gnss_fix
