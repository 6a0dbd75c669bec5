// SPDX-License-Identifier: Apache-2.0
// The direction in which an observer sees a point.
#include "bearing.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace binnacle::aiding {

namespace {

constexpr double nearest_target = 1e-6;  // m: above or below the observer there is no azimuth

}  // namespace

ComponentSpec Bearing::spec() {
  ComponentSpec spec;
  spec.type = "bearing";
  spec.summary = "The direction from an observer to a point: azimuth and optional elevation.";
  spec.source =
      "Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 10.3";
  spec.parameters = {
      parameter::number("sigma", "rad").above(0).required().about("standard deviation of the azimuth's white noise"),
      parameter::number("elevation_sigma", "rad")
          .above(0)
          .about("standard deviation of the elevation's white noise; default: that of the azimuth"),
      parameter::object("point", point_parameters()).about("position of the target, if it is not a block"),
      parameter::origin()};
  spec.ports = {reads("target", "*")
                    .optional()
                    .about("position of the point: vector:2:m or vector:3:m (north, east, down in local axes), "
                           "position or position.ecef"),
                reads("observer", "*")
                    .optional()
                    .about("position of the observer, of the same kind; default: the sample gives it in local axes"),
                reads("attitude", "attitude")
                    .optional()
                    .about("attitude of the observer; with it, angles are relative to its forward axis and its deck"),
                reads("heading", "heading")
                    .optional()
                    .about(
                        "heading of an observer on the ground; with it, the azimuth is relative to its forward axis")};
  spec.fields = {field::level("azimuth", "rad").about("azimuth, clockwise from north or from forward"),
                 field::level("elevation", "rad")
                     .optional()
                     .about("elevation above the horizon or the deck; for a target with three components"),
                 field::level("observer_north", "m").optional().about("position of the observer, if it is not a block"),
                 field::level("observer_east", "m").optional().about("position of the observer, if it is not a block"),
                 field::level("observer_down", "m").optional().about("position of the observer, if it is not a block")};
  spec.example =
      R"json({"channel": "sonar", "blocks": {"target": "target", "observer": "vessel"}, "sigma": "0.5 deg"})json";
  spec.surroundings = R"json({"blocks": {
    "target": {"type": "vector", "size": 3, "unit": "m", "init": [1000, 200, -50], "sigma": 100},
    "vessel": {"type": "vector", "size": 3, "unit": "m", "init": [10, -20, 0], "sigma": 5}}})json";
  return spec;
}

Bearing::Bearing(const Binding& binding)
    : attitude_(binding.port("attitude")),
      heading_(binding.port("heading")),
      azimuth_(binding.field("azimuth")),
      elevation_(binding.field("elevation")) {
  bind_places(binding);
  bind_axes();
  const double sigma = binding.parameters().number("sigma");
  azimuth_variance_ = sigma * sigma;
  elevation_variance_ = azimuth_variance_;
  if (binding.parameters().has("elevation_sigma")) {
    const double own = binding.parameters().number("elevation_sigma");
    elevation_variance_ = own * own;
  }
  declaration_.rows(elevation_.is_bound() ? 2 : 1);
  if (target_) declaration_.reads(target_->port());
  if (observer_) declaration_.reads(observer_->port());
  declaration_.reads(attitude_).reads(heading_).group(rows::these("azimuth", 1, "rad"));
  if (elevation_.is_bound()) declaration_.group(rows::these("elevation", 1, "rad"));
}

void Bearing::bind_places(const Binding& binding) {
  const bool has_point = binding.parameters().has("point");
  if (binding.port("observer").is_bound()) observer_.emplace(binding, "observer");
  if (binding.port("target").is_bound()) target_.emplace(binding, "target");
  if (has_point == target_.has_value())
    throw ComponentError(has_point ? "a block is the target, so there is no 'point'"
                                   : "there is no target: plug a block into 'target', or give its place as 'point'",
                         has_point ? "/point" : "/blocks");
  if (has_point) {
    if (!observer_)
      throw ComponentError("nothing here is estimated: neither target nor observer is a block", "/blocks");
    const std::optional<Point> point = observer_->read(binding.parameters().object("point"), "/point");
    if (!point) throw ComponentError("give lat, lon, height or x, y, z or north, east, down", "/point");
    point_ = observer_->bring(*point);
    return;
  }
  if (observer_) {
    if (observer_->port().dof() != target_->port().dof())
      throw ComponentError("the observer has " + std::to_string(observer_->port().dof()) + " components, the target " +
                               std::to_string(target_->port().dof()),
                           "/blocks/observer");
    if ((observer_->kind() == strapdown::PlaceKind::local) != (target_->kind() == strapdown::PlaceKind::local))
      throw ComponentError("of observer and target one is local, the other on the earth", "/blocks/observer");
    return;
  }
  if (target_->kind() != strapdown::PlaceKind::local)
    throw ComponentError("the target is on the earth, and no block is the observer", "/blocks");
  const char* const fields[] = {"observer_north", "observer_east", "observer_down"};
  for (int i = 0; i < dof(); ++i) {
    place_.push_back(binding.field(fields[i]));
    if (!place_.back().is_bound())
      throw ComponentError(std::string("the channel carries no field for '") + fields[i] +
                               "', and no block is the observer",
                           "/fields");
  }
}

void Bearing::bind_axes() const {
  if (attitude_.is_bound() && heading_.is_bound())
    throw ComponentError("an attitude has a heading: plug in one of them", "/blocks/heading");
  if (dof() == 3) return;
  if (attitude_.is_bound())
    throw ComponentError("directions from the deck need three components: north, east, down", "/blocks/attitude");
  if (elevation_.is_bound())
    throw ComponentError("an elevation needs a target with three components: north, east, down", "/fields/elevation");
}

strapdown::Way Bearing::way(const MeasurementInput& in) const {
  const strapdown::CartesianPlace target =
      target_ ? target_->at(in.x) : strapdown::CartesianPlace{point_, Eigen::Matrix3d::Zero()};
  if (observer_) return strapdown::navigation_way(observer_->kind(), in.x[observer_->port()], target);
  strapdown::CartesianPlace observer{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()};
  for (std::size_t i = 0; i < place_.size(); ++i) observer.r[static_cast<int>(i)] = in.sample[place_[i]];
  return strapdown::cartesian_way(observer, target);
}

/// C: from north, east, down to the axes in which the angles are.
Eigen::Matrix3d Bearing::axes(const PortValues& x) const {
  if (attitude_.is_bound()) return strapdown::dcm_from_quaternion(x[attitude_].as<4>()).transpose();
  Eigen::Matrix3d C = Eigen::Matrix3d::Identity();
  if (!heading_.is_bound()) return C;
  const double sine = std::sin(x[heading_][0]), cosine = std::cos(x[heading_][0]);
  C.topLeftCorner<2, 2>() << cosine, sine, -sine, cosine;
  return C;
}

Result Bearing::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const strapdown::Way way = this->way(in);
  if (!way.d.allFinite()) return Result::invalid("the observer's position is not finite");
  const Eigen::Matrix3d C = axes(in.x);
  const Eigen::Vector3d d = C * way.d;
  const double azimuth = in.sample[azimuth_], rho = std::hypot(d[0], d[1]);
  if (!(rho > nearest_target))
    return Result::unsupported("the target is above, below or where the observer is: no azimuth");
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
  if (!out.H) return Result::ok();
  Eigen::Matrix<double, 2, 3> by_d;                    // in the measured axes, then in north, east, down
  by_d << -d[1] / (rho * rho), d[0] / (rho * rho), 0,  //
      d[2] * d[0] / (rho * square), d[2] * d[1] / (rho * square), -rho / square;
  by_d = (by_d * C).eval();
  const auto write = [&](Port port, const Eigen::Matrix<double, 2, 3>& by_error, int first) {
    if (const MatrixView H = out.H[port])
      for (int row = 0; row < out.rows; ++row)
        for (int i = 0; i < port.dof(); ++i) H(row, i) = by_error(row, first + i);
  };
  if (target_) write(target_->port(), by_d * way.by_to, 0);
  if (observer_) write(observer_->port(), by_d * way.by_from, 0);
  const Eigen::Matrix<double, 2, 3> by_turn = by_d * strapdown::skew(way.d);
  write(attitude_, by_turn, 0);
  write(heading_, by_turn, 2);  // a heading turns about down
  return Result::ok();
}

}  // namespace binnacle::aiding
