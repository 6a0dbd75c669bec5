// SPDX-License-Identifier: Apache-2.0
// The direction in which an observer sees a point.
#include "bearing.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace binnacle::aiding {

namespace {

constexpr double nearest = 1e-6;  // m: above or below the observer there is no azimuth

}  // namespace

ComponentSpec Bearing::spec() {
  ComponentSpec spec;
  spec.type = "bearing";
  spec.summary = "The direction in which an observer sees a point: azimuth and, where there is one, elevation.";
  spec.source =
      "Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 10.3";
  spec.parameters = {parameter::number("sigma", "rad").above(0).required().about("of the azimuth's white noise"),
                     parameter::number("elevation_sigma", "rad")
                         .above(0)
                         .about("of the elevation's white noise; as the azimuth's if absent")};
  spec.ports = {reads("target", "vector:*:m").about("the point: north, east, or north, east, down, in local axes"),
                reads("observer", "vector:*:m").optional().about("who sees it, alike; else the sample has its place")};
  spec.fields = {
      field::level("azimuth", "rad").about("clockwise from north"),
      field::level("elevation", "rad").optional().about("above the horizon; of a target with three components"),
      field::level("observer_north", "m").optional().about("place of the observer, unless it is a block"),
      field::level("observer_east", "m").optional().about("place of the observer, unless it is a block"),
      field::level("observer_down", "m").optional().about("place of the observer, unless it is a block")};
  spec.example =
      R"json({"channel": "sonar", "blocks": {"target": "target", "observer": "vessel"}, "sigma": "0.5 deg"})json";
  spec.surroundings = R"json({"blocks": {
    "target": {"type": "vector", "size": 3, "unit": "m", "init": [1000, 200, -50], "sigma": 100},
    "vessel": {"type": "vector", "size": 3, "unit": "m", "init": [10, -20, 0], "sigma": 5}}})json";
  return spec;
}

Bearing::Bearing(const Binding& binding)
    : target_(binding.port("target")),
      observer_(binding.port("observer")),
      azimuth_(binding.field("azimuth")),
      elevation_(binding.field("elevation")) {
  const int dof = target_.dof();
  if (dof != 2 && dof != 3)
    throw ComponentError("the target has " + std::to_string(dof) + " components; 2 or 3 are possible",
                         "/blocks/target");
  if (observer_.is_bound() && observer_.dof() != dof)
    throw ComponentError("the observer has " + std::to_string(observer_.dof()) + " components, the target " +
                             std::to_string(dof),
                         "/blocks/observer");
  const char* const fields[] = {"observer_north", "observer_east", "observer_down"};
  for (int i = 0; i < dof && !observer_.is_bound(); ++i) {
    place_.push_back(binding.field(fields[i]));
    if (!place_.back().is_bound())
      throw ComponentError(std::string("the channel carries no field for '") + fields[i] +
                               "', and no block is the observer",
                           "/fields");
  }
  if (dof == 2 && elevation_.is_bound())
    throw ComponentError("an elevation needs a target with three components: north, east, down", "/fields/elevation");
  const double sigma = binding.parameters().number("sigma");
  azimuth_variance_ = sigma * sigma;
  elevation_variance_ = azimuth_variance_;
  if (binding.parameters().has("elevation_sigma")) {
    const double own = binding.parameters().number("elevation_sigma");
    elevation_variance_ = own * own;
  }
  declaration_.rows(elevation_.is_bound() ? 2 : 1).reads(target_).reads(observer_);
  declaration_.group(rows::these("azimuth", 1, "rad"));
  if (elevation_.is_bound()) declaration_.group(rows::these("elevation", 1, "rad"));
}

Result Bearing::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const int dof = target_.dof();
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (int i = 0; i < dof; ++i)
    d[i] =
        in.x[target_][i] - (observer_.is_bound() ? in.x[observer_][i] : in.sample[place_[static_cast<std::size_t>(i)]]);
  if (!d.allFinite()) return Result::invalid("the observer's place is not finite");
  const double azimuth = in.sample[azimuth_], rho = std::hypot(d[0], d[1]);
  if (!(rho > nearest)) return Result::unsupported("the target is where the observer is: it has no azimuth");
  const bool has_elevation = elevation_.is_bound();
  if (!std::isfinite(azimuth) || (has_elevation && !std::isfinite(in.sample[elevation_])))
    return Result::invalid("an angle is not finite");
  out.rows = has_elevation ? 2 : 1;
  out.residual[0] = std::remainder(azimuth - std::atan2(d[1], d[0]), 2 * std::numbers::pi);
  out.R(0, 0) = azimuth_variance_;
  const double square = d.squaredNorm();
  if (has_elevation) {
    out.residual[1] = in.sample[elevation_] - std::atan2(-d[2], rho);
    out.R(1, 1) = elevation_variance_;
  }
  const Eigen::Vector3d of_azimuth(-d[1] / (rho * rho), d[0] / (rho * rho), 0);
  const Eigen::Vector3d of_elevation(d[2] * d[0] / (rho * square), d[2] * d[1] / (rho * square), -rho / square);
  for (const auto& [port, sign] : {std::pair(target_, 1.0), std::pair(observer_, -1.0)})
    if (const MatrixView H = out.H[port])
      for (int i = 0; i < dof; ++i) {
        H(0, i) = sign * of_azimuth[i];
        if (has_elevation) H(1, i) = sign * of_elevation[i];
      }
  return Result::ok();
}

}  // namespace binnacle::aiding
