// SPDX-License-Identifier: Apache-2.0
// The displacement from an instant to now.
#include "relative_position.hpp"

#include <array>
#include <cmath>
#include <string>

#include "binnacle/geodesy.hpp"
#include "strapdown/local_axes.hpp"
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
  spec.parameters = {
      parameter::choice("frame", {"body", "navigation"})
          .defaults("\"body\"")
          .about("axes of the displacement: of the body at the begin of the interval, or north, east, down there (of a "
                 "local position: its own axes)"),
      parameter::vector("sigma", "m", 3)
          .above(0)
          .plausible(1e-5, 1e3)
          .about("standard deviation by axis, where the channel carries none; required if it does not"),
      parameter::number("relative", "1")
          .at_least(0)
          .defaults("0")
          .about("adds (relative * length of the displacement)^2 to each variance"),
      parameter::time("tolerance")
          .at_least(0)
          .defaults("\"1 us\"")
          .about("by how much the begin of the interval may differ from the instant of the copy")};
  spec.ports = {
      reads("position", "*").about("now: kind position (geodetic), or vector:1:m to vector:3:m (local)"),
      reads("copy", "*").about("the position at the begin of the interval: a copy that a 'clone' keeps"),
      reads("attitude", "attitude").optional().about("for body axes: the copy of the attitude, of that instant"),
      reads("age", "vector:1:s").about("of the copy: the block that the 'clone' advances")};
  spec.fields = {field::increment("dx", "m").about("displacement over the interval: forward, or north"),
                 field::increment("dy", "m").optional().about("right, or east"),
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
      is_geodetic_(binding.block("position").kind == "position"),
      is_in_body_axes_(binding.parameters().text("frame") == "body"),
      relative_(binding.parameters().number("relative")),
      tolerance_(seconds(binding.parameters().time("tolerance"))) {
  const std::string& kind = binding.block("position").kind;
  const bool is_local = kind == "vector:1:m" || kind == "vector:2:m" || kind == "vector:3:m";
  if (!is_geodetic_ && !is_local)
    throw ComponentError("a position is of the kind 'position' or 'vector:3:m'; found '" + kind +
                             "' (of ECEF blocks gnss_range/geodetic_position makes one)",
                         "/blocks/position");
  if (binding.block("copy").kind != kind)
    throw ComponentError("the copy is of the kind '" + binding.block("copy").kind + "', the position of the kind '" +
                             kind + "'",
                         "/blocks/copy");
  if (is_in_body_axes_ != attitude_.is_bound())
    throw ComponentError(is_in_body_axes_
                             ? "a displacement in body axes needs the attitude at its begin: plug the copy of the "
                               "attitude into 'attitude', or say \"frame\": \"navigation\""
                             : "\"frame\": \"navigation\" takes no attitude",
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

RelativePosition::Way RelativePosition::way(const PortValues& x) const {
  if (!is_geodetic_) {
    Way way{Vector3d::Zero(), Matrix3d::Identity(), -Matrix3d::Identity()};
    for (int i = 0; i < position_.dof(); ++i) way.d[i] = x[position_][i] - x[copy_][i];
    return way;
  }
  const Vector3d now = x[position_].as<3>(), then = x[copy_].as<3>();
  const Matrix3d C_en = geodesy::C_en(then[0], then[1]);
  const Vector3d d = C_en.transpose() * (geodesy::ecef_from_lla(now) - geodesy::ecef_from_lla(then));
  return {d, C_en.transpose() * geodesy::C_en(now[0], now[1]),
          -Matrix3d::Identity() + strapdown::skew(d) * strapdown::axes_per_metre(then)};
}

Result RelativePosition::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const SampleView& sample = in.sample;
  if (sample.t0 == no_time) return Result::invalid("the sample has no interval, so its displacement has no begin");
  if (!(std::abs(seconds(sample.t - sample.t0) - in.x[age_][0]) <= tolerance_))
    return Result::unsupported("its interval begins at another instant than that of the copy");
  const int rows = position_.dof();
  Vector3d z = Vector3d::Zero();
  for (int i = 0; i < rows; ++i) z[i] = sample[axes_[static_cast<std::size_t>(i)].z];
  if (!z.allFinite()) return Result::invalid("the displacement is not finite");
  const double by_length = relative_ > 0 ? relative_ * relative_ * z.squaredNorm() : 0;
  if (!std::isfinite(by_length)) return Result::invalid("the displacement is beyond all reason");
  for (int i = 0; i < rows; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    const double sigma = axis.reported.is_bound() ? sample[axis.reported] : axis.sigma;
    if (!(sigma > 0) || !std::isfinite(sigma * sigma))
      return Result::invalid("a reported standard deviation is 0, negative or not finite");
    out.R(i, i) = sigma * sigma + by_length;
  }
  const Way way = this->way(in.x);
  const Matrix3d axes = is_in_body_axes_ ? Matrix3d(strapdown::dcm_from_quaternion(in.x[attitude_].as<4>()).transpose())
                                         : Matrix3d(Matrix3d::Identity());
  out.rows = rows;
  out.residual.as() = (z - axes * way.d).head(rows);
  if (const MatrixView H = out.H[position_]) H.as() = (axes * way.by_position).topLeftCorner(rows, rows);
  if (const MatrixView H = out.H[copy_]) H.as() = (axes * way.by_copy).topLeftCorner(rows, rows);
  if (const MatrixView H = out.H[attitude_]) H.as() = axes * strapdown::skew(way.d);
  return Result::ok();
}

}  // namespace binnacle::clone
