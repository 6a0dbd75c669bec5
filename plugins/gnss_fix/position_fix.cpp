// SPDX-License-Identifier: Apache-2.0
// A position as a receiver computes it.
#include "position_fix.hpp"

#include <cmath>
#include <numbers>

#include "strapdown/earth.hpp"

namespace binnacle::gnss_fix {

namespace {

constexpr const char* position_sigma_prefix = "position_sd";
constexpr std::array<const char*, 3> position_sigma_flaws = {"position_sd_n is 0, negative or not finite",
                                                             "position_sd_e is 0, negative or not finite",
                                                             "position_sd_d is 0, negative or not finite"};

}  // namespace

ComponentSpec PositionFix::spec() {
  ComponentSpec spec;
  spec.type = "position_fix";
  spec.summary = "A geodetic position from a receiver, with the reported standard deviations if there are any.";
  spec.source = "paper 003, equation (11)";
  spec.parameters = ReportedSigma::parameters("m");
  spec.ports = {reads("position", "position").about("position of the antenna: a position block, or a lever_arm"),
                reads("bias", "vector:3:m")
                    .optional()
                    .about("time-correlated error of the receiver, north, east, down: measured = true + bias")};
  spec.fields = {field::level("lat", "rad").about("geodetic latitude, WGS-84"),
                 field::level("lon", "rad").about("longitude, east positive"),
                 field::level("height", "m").about("height above the ellipsoid")};
  for (FieldSpec& field : ReportedSigma::fields(position_sigma_prefix, "m")) spec.fields.push_back(std::move(field));
  spec.example = R"json({"channel": "gnss", "blocks": {"position": "antenna"}, "sigma": ["2 m", "2 m", "4 m"],
    "floor": "0.5 m", "gate": 0.999})json";
  return spec;
}

PositionFix::PositionFix(const Binding& binding)
    : position_(binding.port("position")),
      bias_(binding.port("bias")),
      z_(binding.fields("lat", "lon", "height")),
      sigma_(binding, position_sigma_prefix, position_sigma_flaws) {
  declaration_.rows(3).reads(position_).reads(bias_).group(rows::of("position", position_));
}

Result PositionFix::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const Eigen::Vector3d z = in.sample[z_];
  if (!z.allFinite()) return Result::invalid("latitude, longitude or height is not finite");
  if (std::abs(z[0]) > std::numbers::pi / 2) return Result::invalid("the latitude lies beyond a pole");
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  out.rows = 3;
  out.residual.as<3>() = strapdown::position_minus(z, in.x[position_].as<3>());
  if (bias_.is_bound()) out.residual.as<3>() -= in.x[bias_].as<3>();
  if (const MatrixView H = out.H[position_]) H.as<3, 3>().setIdentity();
  if (const MatrixView H = out.H[bias_]) H.as<3, 3>().setIdentity();
  return Result::ok();
}

}  // namespace binnacle::gnss_fix
