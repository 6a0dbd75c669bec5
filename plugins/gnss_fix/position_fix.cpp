// SPDX-License-Identifier: Apache-2.0
// A position as a receiver computes it.
#include "position_fix.hpp"

#include <cmath>
#include <numbers>

#include "strapdown/earth.hpp"

namespace binnacle::gnss_fix {

namespace {

enum Field { lat, lon, height, first_sigma };

}  // namespace

ComponentSpec PositionFix::spec() {
  ComponentSpec spec;
  spec.type = "position_fix";
  spec.summary = "A geodetic position from a receiver, with its own standard deviations where it has them.";
  spec.source = "paper 003, equation (11)";
  spec.parameters = ReportedSigma::parameters("m");
  spec.ports = {reads("position", "position", "of the antenna: a position block, or a lever_arm")};
  spec.fields = {{"lat", "rad", FieldKind::level, false, false, "geodetic latitude, WGS-84"},
                 {"lon", "rad", FieldKind::level, false, false, "longitude, east positive"},
                 {"height", "m", FieldKind::level, false, false, "above the ellipsoid"}};
  for (FieldSpec& field : ReportedSigma::fields("position_sd", "m")) spec.fields.push_back(std::move(field));
  spec.example = R"json({"channel": "gnss", "blocks": {"position": "antenna"}, "sigma": ["2 m", "2 m", "4 m"],
    "floor": "0.5 m", "gate": 0.999})json";
  return spec;
}

PositionFix::PositionFix(const Binding& binding) : sigma_(binding, first_sigma) {
  declaration_.max_rows = 3;
  declaration_.read_ports = {0};
  declaration_.groups = {{"position", 0, 3, "m", 0}};
}

Result PositionFix::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                              const legacy::Context& /*context*/, std::byte* /*memory*/,
                              legacy::Linearization& out) const {
  const auto z = vector_at<3>(sample.fields);
  if (!z.allFinite()) return Result::invalid("latitude, longitude or height is not finite");
  if (std::abs(z[lat]) > std::numbers::pi / 2) return Result::invalid("the latitude lies beyond a pole");
  if (const Result result = sigma_.write_variances(sample.fields, out.R); !result) return result;
  out.rows = 3;
  vector_at<3>(out.residual) = strapdown::position_minus(z, vector_at<3>(x[0]));
  out.H[0].as<3, 3>().setIdentity();
  return Result::ok();
}

}  // namespace binnacle::gnss_fix
