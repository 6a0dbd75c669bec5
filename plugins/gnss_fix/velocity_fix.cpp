// SPDX-License-Identifier: Apache-2.0
// A velocity as a receiver computes it.
#include "velocity_fix.hpp"

namespace binnacle::gnss_fix {

namespace {

constexpr const char* velocity_sigma_prefix = "velocity_sd";
constexpr std::array<const char*, 3> velocity_sigma_flaws = {"velocity_sd_n is 0, negative or not finite",
                                                             "velocity_sd_e is 0, negative or not finite",
                                                             "velocity_sd_d is 0, negative or not finite"};

}  // namespace

ComponentSpec VelocityFix::spec() {
  ComponentSpec spec;
  spec.type = "velocity_fix";
  spec.summary = "A velocity over ground from a receiver, with the reported standard deviations if there are any.";
  spec.source = "paper 003, equation (11)";
  spec.parameters = ReportedSigma::parameters("m/s");
  spec.ports = {
      reads("velocity", "velocity.ned").about("velocity of the antenna: a velocity block, or a lever_arm_velocity")};
  spec.fields = {field::level("vn", "m/s").about("velocity over ground, north"),
                 field::level("ve", "m/s").about("velocity over ground, east"),
                 field::level("vd", "m/s").about("velocity over ground, down")};
  for (FieldSpec& field : ReportedSigma::fields(velocity_sigma_prefix, "m/s")) spec.fields.push_back(std::move(field));
  spec.example = R"json({"channel": "gnss", "blocks": {"velocity": "velocity"}, "sigma": "0.1 m/s",
    "floor": "0.03 m/s", "gate": 0.999})json";
  return spec;
}

VelocityFix::VelocityFix(const Binding& binding)
    : velocity_(binding.port("velocity")),
      z_(binding.fields("vn", "ve", "vd")),
      sigma_(binding, velocity_sigma_prefix, velocity_sigma_flaws) {
  declaration_.rows(3).reads(velocity_).group(rows::of("velocity", velocity_));
}

Result VelocityFix::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const Eigen::Vector3d z = in.sample[z_];
  if (!z.allFinite()) return Result::invalid("a velocity is not finite");
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  out.rows = 3;
  out.residual.as<3>() = z - in.x[velocity_].as<3>();
  if (const MatrixView H = out.H[velocity_]) H.as<3, 3>().setIdentity();
  return Result::ok();
}

}  // namespace binnacle::gnss_fix
