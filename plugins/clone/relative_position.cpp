// SPDX-License-Identifier: Apache-2.0
// The displacement from an instant to now.
#include "relative_position.hpp"

#include <array>
#include <cmath>
#include <string>

#include "strapdown/rotation.hpp"

namespace binnacle::clone {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<const char*, 3> names = {"dx", "dy", "dz"};

std::string sigma_name(const char* name) { return std::string(name) + "_sd"; }

}  // namespace

ComponentSpec RelativePosition::spec() {
  ComponentSpec spec;
  spec.type = "relative_position";
  spec.summary =
      "The displacement over a sample's interval, from a copy of the position: visual odometry, scan matching.";
  spec.source = "Roumeliotis and Burdick, Stochastic cloning, IEEE ICRA 2002, section IV";
  spec.parameters = {parameter::choice("frame", {"body", "navigation", "ecef"})
                         .defaults("\"body\"")
                         .about("axes of the displacement: those of the body at the start of the interval; north, "
                                "east, down there (the axes of a local position); or earth-centred"),
                     parameter::vector("sigma", "m", 3)
                         .above(0)
                         .plausible(1e-5, 1e3)
                         .about("standard deviation by axis, used if the channel carries none; then required"),
                     parameter::number("relative", "1")
                         .at_least(0)
                         .defaults("0")
                         .about("relative noise: adds (relative * length of the displacement)^2 to each variance"),
                     parameter::time("tolerance")
                         .at_least(0)
                         .defaults("\"1 us\"")
                         .about("largest difference between the start of the interval and the instant of the copy")};
  spec.ports = {
      reads("position", "*")
          .about("current position of the sensor: kind position (geodetic), position.ecef, or vector:1:m to vector:3:m "
                 "(local)"),
      reads("copy", "*").about("position at the start of the interval: a copy that a 'clone' keeps"),
      reads("attitude", "attitude").optional().about("copy of the attitude at the same instant, for body axes"),
      reads("age", "vector:1:s").about("age of the copy: the block that the 'clone' advances")};
  spec.fields = {field::increment("dx", "m").about("displacement over the interval: forward, north, or x"),
                 field::increment("dy", "m").optional().about("displacement to the right, or east"),
                 field::increment("dz", "m").optional().about("down")};
  for (const char* name : names)
    spec.fields.push_back(
        field::level(sigma_name(name), "m").optional().about(std::string("standard deviation of ") + name));
  spec.example = R"json({"channel": "camera", "blocks": {"position": "position", "copy": "position_then",
    "attitude": "attitude_then", "age": "age"}, "sigma": ["3 cm", "3 cm", "5 cm"], "gate": 0.999})json";
  spec.surroundings = R"json({"time": 2, "sources": {"camera": {"type": "core/pushed", "fields": {
      "dx": {"unit": "m", "kind": "increment"}, "dy": {"unit": "m", "kind": "increment"}, "dz": {"unit": "m", "kind": "increment"}}}},
    "blocks": {
    "position": {"type": "navigation/position", "init": {"lat": "37.4001 deg", "lon": "126.9001 deg", "height": "61 m"}, "sigma": 1},
    "position_then": {"type": "navigation/position", "init": {"lat": "37.4 deg", "lon": "126.9 deg", "height": "60 m"}, "sigma": 1},
    "attitude_then": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": -0.6}, "sigma": 0.02},
    "age": {"type": "vector", "size": 1, "unit": "s", "init": 0.01, "sigma": 1e-8}}})json";
  return spec;
}

RelativePosition::RelativePosition(const Binding& binding)
    : position_(binding.port("position")),
      copy_(binding.port("copy")),
      attitude_(binding.port("attitude")),
      age_(binding.port("age")),
      is_in_body_axes_(binding.parameters().text("frame") == "body"),
      is_in_ecef_(binding.parameters().text("frame") == "ecef"),
      relative_(binding.parameters().number("relative")),
      tolerance_(seconds(binding.parameters().time("tolerance"))) {
  const std::string& kind = binding.block("position").kind;
  const auto place = strapdown::place_kind(kind);
  if (!place)
    throw ComponentError("a position is of the kind 'position', 'position.ecef' or 'vector:3:m'; found '" + kind + "'",
                         "/blocks/position");
  kind_ = *place;
  if (is_in_ecef_ && kind_ == strapdown::PlaceKind::local)
    throw ComponentError("\"frame\": \"ecef\" is for a position on the earth; a local one has \"navigation\"",
                         "/frame");
  if (binding.block("copy").kind != kind)
    throw ComponentError("the copy is of the kind '" + binding.block("copy").kind + "', the position of the kind '" +
                             kind + "'",
                         "/blocks/copy");
  if (is_in_body_axes_ != attitude_.is_bound())
    throw ComponentError(is_in_body_axes_
                             ? std::string("a displacement in body axes needs the attitude at its start: plug the copy "
                                           "of the attitude into 'attitude', or say \"frame\": \"navigation\"")
                             : "\"frame\": \"" + binding.parameters().text("frame") + "\" takes no attitude",
                         is_in_body_axes_ ? "/blocks" : "/blocks/attitude");
  const int rows = position_.dof();
  if (is_in_body_axes_ && rows != 3)
    throw ComponentError("body axes are three, the position has " + std::to_string(rows), "/blocks/position");
  const bool has_sigma = binding.parameters().has("sigma");
  for (int i = 0; i < rows; ++i) {
    const char* const name = names[static_cast<std::size_t>(i)];
    Axis axis{binding.field(name), binding.field(sigma_name(name)), 0};
    if (!axis.z.is_bound())
      throw ComponentError(std::string("the channel carries no field for '") + name + "'", "/fields");
    if (has_sigma) axis.sigma = binding.parameters().vector("sigma")[i];
    if (!has_sigma && !axis.reported.is_bound())
      throw ComponentError("missing key 'sigma': the channel carries no '" + sigma_name(name) + "'", "");
    axes_.push_back(axis);
  }
  declaration_.rows(rows).reads(position_).reads(copy_).reads(attitude_).group(rows::these("displacement", rows, "m"));
}

strapdown::Way RelativePosition::way(const PortValues& x) const {
  const strapdown::CartesianPlace now = strapdown::cartesian(kind_, x[position_]);
  return is_in_ecef_ ? strapdown::cartesian_way(strapdown::cartesian(kind_, x[copy_]), now)
                     : strapdown::navigation_way(kind_, x[copy_], now);
}

Result RelativePosition::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const SampleView& sample = in.sample;
  if (sample.t0 == no_time) return Result::invalid("the sample has no interval, so its displacement has no start");
  if (!(std::abs(seconds(sample.t - sample.t0) - in.x[age_][0]) <= tolerance_))
    return Result::unsupported("its interval begins at another instant than that of the copy");
  const int rows = position_.dof();
  Vector3d z = Vector3d::Zero();
  for (int i = 0; i < rows; ++i) z[i] = sample[axes_[static_cast<std::size_t>(i)].z];
  if (!z.allFinite()) return Result::invalid("the displacement is not finite");
  const double by_length = relative_ > 0 ? relative_ * relative_ * z.squaredNorm() : 0;
  if (!std::isfinite(by_length)) return Result::invalid("the displacement is implausible");
  for (int i = 0; i < rows; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    const double sigma = axis.reported.is_bound() ? sample[axis.reported] : axis.sigma;
    if (!(sigma > 0) || !std::isfinite(sigma * sigma))
      return Result::invalid("a reported standard deviation is 0, negative or not finite");
    out.R(i, i) = sigma * sigma + by_length;
  }
  const strapdown::Way way = this->way(in.x);
  const Matrix3d axes = is_in_body_axes_ ? Matrix3d(strapdown::dcm_from_quaternion(in.x[attitude_].as<4>()).transpose())
                                         : Matrix3d(Matrix3d::Identity());
  out.rows = rows;
  out.residual.as() = (z - axes * way.d).head(rows);
  if (const MatrixView H = out.H[position_]) H.as() = (axes * way.by_to).topLeftCorner(rows, rows);
  if (const MatrixView H = out.H[copy_]) H.as() = (axes * way.by_from).topLeftCorner(rows, rows);
  if (const MatrixView H = out.H[attitude_]) H.as() = axes * strapdown::skew(way.d);
  return Result::ok();
}

}  // namespace binnacle::clone
