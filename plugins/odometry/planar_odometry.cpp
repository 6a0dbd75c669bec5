// SPDX-License-Identifier: Apache-2.0
// Dead reckoning on the ground: speed and yaw rate drive position and heading.
#include "planar_odometry.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Geometry>

#include "planar_arc.hpp"
#include "strapdown/local_axes.hpp"

namespace binnacle::odometry {

namespace {

double squared(double x) { return x * x; }

std::vector<ParameterSpec> noise_parameters() {
  using namespace parameter;
  return {number("speed_noise", "m/sqrt(s)")
              .at_least(0)
              .plausible(1e-5, 100)
              .required()
              .about("white noise of the speed: the along-track sigma after the time t is speed_noise sqrt(t)"),
          number("yaw_rate_noise", "rad/sqrt(s)")
              .at_least(0)
              .plausible(1e-7, 1)
              .required()
              .about("white noise of the yaw rate: the heading sigma after the time t is yaw_rate_noise sqrt(t)"),
          number("distance_noise", "m/sqrt(m)")
              .at_least(0)
              .defaults("0")
              .about("along-track random walk by distance driven, from wheel slip"),
          number("turn_noise", "rad/sqrt(rad)").at_least(0).defaults("0").about("heading random walk by angle turned"),
          number("side_noise", "m/sqrt(m)")
              .at_least(0)
              .defaults("0")
              .about("cross-track random walk by distance driven, from sideways slip"),
          number("height_noise", "m/sqrt(m)")
              .at_least(0)
              .required()
              .about("height random walk by distance driven, from the slope of the road")};
}

}  // namespace

ComponentSpec PlanarOdometry::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "planar_odometry";
  spec.summary = "Position and heading of a ground vehicle, propagated by its speed and yaw rate, without an IMU.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 6.4; "
      "Thrun, "
      "Burgard and Fox, Probabilistic Robotics, 2005, sections 5.3 and 5.4 (arc; noise by way and by angle)";
  spec.parameters = noise_parameters();
  spec.parameters.push_back(choice("positive_turn", {"clockwise", "anticlockwise"})
                                .defaults("\"clockwise\"")
                                .about("direction of a positive yaw rate, seen from above"));
  spec.parameters.push_back(
      boolean("earth_rate")
          .defaults("true")
          .about("true: the yaw rate is from a gyroscope and contains the earth rate; false: it is from wheel speeds"));
  spec.parameters.push_back(number("track", "m")
                                .above(0)
                                .plausible(1e-3, 100)
                                .about("distance between the left and the right wheel; with it the wheel speeds are "
                                       "the input, instead of speed and yaw rate"));
  spec.parameters.push_back(
      object("bridge",
             {number("acceleration", "m/s^2").at_least(0).defaults("1").about("acceleration during the hole, 1-sigma"),
              number("rate", "rad/s").at_least(0).defaults("\"5 deg/s\"").about("yaw rate during the hole, 1-sigma")})
          .defaults("{}")
          .about("additional noise of a step that bridges a hole in the input"));
  spec.ports = {advances("ecef_position", "position.ecef")
                    .optional()
                    .about("ECEF position of the vehicle; alternative to position"),
                advances("position", "position")
                    .optional()
                    .about("geodetic position of the vehicle; alternative to ecef_position"),
                advances("heading", "heading").about("heading of the vehicle: the direction in which it rolls"),
                reads("scale", "vector:1:1")
                    .optional()
                    .about("scale factor error s: a wheel sensor reports (1 + s) times the speed"),
                reads("yaw_rate_bias", "vector:1:rad/s").optional().about("bias of the yaw rate, clockwise positive")};
  spec.fields = {
      field::rate("speed", "m/s").optional().about("speed of the vehicle, forward positive"),
      field::rate("yaw_rate", "rad/s").optional().about("yaw rate of the vehicle; sign as in 'positive_turn'"),
      field::rate("left_speed", "m/s").optional().about("speed of the left wheel, instead of speed and yaw rate"),
      field::rate("right_speed", "m/s").optional().about("speed of the right wheel")};
  spec.example = R"json({"input": "car", "blocks": {"position": "position", "heading": "heading", "scale": "scale",
    "yaw_rate_bias": "bias"}, "speed_noise": "0.1 m/sqrt(s)", "yaw_rate_noise": "0.1 deg/sqrt(s)",
    "height_noise": "0.1 m/sqrt(m)", "distance_noise": "0.05 m/sqrt(m)"})json";
  spec.surroundings = R"json({"blocks": {
    "position": {"type": "navigation/position", "init": {"lat": "52.5 deg", "lon": "13.4 deg", "height": "80 m"}, "sigma": "10 m"},
    "heading": {"type": "odometry/heading", "init": {"yaw": "100 deg"}, "sigma": "10 deg"},
    "scale": {"type": "vector", "size": 1, "unit": "1", "sigma": 0.02},
    "bias": {"type": "vector", "size": 1, "unit": "rad/s", "sigma": 0.001}},
    "sample": {"speed": 8, "yaw_rate": 0.2}})json";
  return spec;
}

PlanarOdometry::PlanarOdometry(const Binding& binding)
    : heading_(binding.port("heading")), scale_(binding.port("scale")), bias_(binding.port("yaw_rate_bias")) {
  is_ecef_ = binding.port("ecef_position").is_bound();
  if (is_ecef_ == binding.port("position").is_bound())
    throw ComponentError("plug a block into one of the ports 'position' and 'ecef_position'", "/blocks");
  position_ = binding.port(is_ecef_ ? "ecef_position" : "position");
  const Parameters& parameters = binding.parameters();
  turn_ = parameters.text("positive_turn") == "clockwise" ? 1.0 : -1.0;
  feels_earth_ = parameters.boolean("earth_rate");
  bind_input(binding);
  S_speed_ = squared(parameters.number("speed_noise"));
  S_distance_ = squared(parameters.number("distance_noise"));
  S_side_ = squared(parameters.number("side_noise"));
  S_height_ = squared(parameters.number("height_noise"));
  S_yaw_ = squared(parameters.number("yaw_rate_noise"));
  S_turn_ = squared(parameters.number("turn_noise"));
  const Parameters bridge = parameters.object("bridge");
  bridge_acceleration_ = bridge.number("acceleration");
  bridge_rate_ = bridge.number("rate");
  phi_pp_ = declaration_.couples(position_, position_);
  phi_ph_ = declaration_.couples(position_, heading_);
  phi_ps_ = declaration_.couples(position_, scale_);
  phi_pb_ = declaration_.couples(position_, bias_);
  phi_hp_ = declaration_.couples(heading_, position_);
  phi_hh_ = declaration_.couples(heading_, heading_);
  phi_hs_ = declaration_.couples(heading_, scale_);
  phi_hb_ = declaration_.couples(heading_, bias_);
  q_pp_ = declaration_.adds_noise(position_, position_);
  q_ph_ = declaration_.adds_noise(position_, heading_);
  q_hh_ = declaration_.adds_noise(heading_, heading_);
}

void PlanarOdometry::bind_input(const Binding& binding) {
  speed_ = binding.field("speed"), yaw_rate_ = binding.field("yaw_rate");
  left_ = binding.field("left_speed"), right_ = binding.field("right_speed");
  const bool is_by_wheels = binding.parameters().has("track");
  const Field &first = is_by_wheels ? left_ : speed_, &second = is_by_wheels ? right_ : yaw_rate_;
  if (!first.is_bound() || !second.is_bound())
    throw ComponentError(std::string("the input carries no field for '") +
                             (is_by_wheels ? (first.is_bound() ? "right_speed" : "left_speed")
                                           : (first.is_bound() ? "yaw_rate" : "speed")) +
                             "': with 'track' it takes left_speed and right_speed, without it speed and yaw_rate",
                         "/fields");
  if (!is_by_wheels) return;
  track_ = binding.parameters().number("track");
  feels_earth_ = false;
}

PlanarOdometry::Reading PlanarOdometry::read(const InputSample& sample) const {
  if (track_ == 0) return {sample[speed_], turn_ * sample[yaw_rate_]};
  return {(sample[left_] + sample[right_]) / 2, (sample[left_] - sample[right_]) / track_};
}

/// What a sample's step is made of.
struct PlanarOdometry::Parts {
  Eigen::Vector3d lla;
  Eigen::Matrix3d C_en;  // of an ECEF position; else not used
  strapdown::Radii R;
  PlanarArc arc;
  double speed, rate, scale, dt;
};

struct PlanarOdometry::Moved {
  Parts parts;
  Pose pose;
  Jacobian J;
};

PlanarOdometry::Moved PlanarOdometry::move(const Pose& pose, double scale, double bias,
                                           const InputSample& sample) const {
  const Eigen::Vector3d lla = is_ecef_ ? strapdown::lla_from_ecef(pose.position) : pose.position;
  const Reading reading = read(sample);
  const double speed = reading.speed / (1 + scale);
  const double rate = reading.rate - bias + (feels_earth_ ? strapdown::wgs84::omega_ie * std::sin(lla[0]) : 0.0);
  Moved moved{{lla, Eigen::Matrix3d::Identity(), strapdown::radii(lla[0]), PlanarArc(pose.yaw, speed, rate, sample.dt),
               speed, rate, scale, sample.dt},
              {},
              {}};
  const Eigen::Vector3d way(moved.parts.arc.way[0], moved.parts.arc.way[1], 0);
  if (is_ecef_) {
    moved.parts.C_en = strapdown::C_en(lla[0], lla[1]);
    moved.pose.position = pose.position + moved.parts.C_en * way;
  } else {
    moved.pose.position = strapdown::position_plus(lla, way);
  }
  const double convergence = std::tan(lla[0]) / (moved.parts.R.transverse + lla[2]);
  moved.pose.yaw = std::remainder(pose.yaw + rate * sample.dt + way[1] * convergence, 2 * std::numbers::pi);
  return moved;
}

/// ∂(position, heading)⁺ by the errors of what they come from; a position's error in its own axes.
void PlanarOdometry::differentiate(const Parts& parts, Moved& moved) const {
  const auto& [lla, C_en, R, arc, speed, rate, scale, dt] = parts;
  const double tangent = std::tan(lla[0]), transverse = R.transverse + lla[2], meridian = R.meridian + lla[2];
  const double convergence = tangent / transverse;
  // By (north, east, down) of the place: through the earth's rate, and through what a metre is in radians.
  const double rate_by_north = feels_earth_ ? strapdown::wgs84::omega_ie * std::cos(lla[0]) / meridian : 0.0;
  Eigen::Matrix<double, 2, 4> way;  // ∂way by yaw, scale, bias, north
  way << arc.by_yaw, -speed / (1 + scale) * arc.by_speed, -arc.by_rate, rate_by_north * arc.by_rate;

  Eigen::Matrix3d by_place = Eigen::Matrix3d::Zero();  // north, east, down; the identity is added at the end
  const double n = arc.way[0], e = arc.way[1];
  if (is_ecef_) {
    const Eigen::Matrix3d dtheta = strapdown::axes_per_metre(lla);
    for (int i = 0; i < 3; ++i) by_place.col(i) += dtheta.col(i).cross(Eigen::Vector3d(n, e, 0));
  } else {
    const strapdown::Advance advance = strapdown::advance(lla, {n, e, 0});
    by_place = advance.by_place - Eigen::Matrix3d::Identity();
    way = advance.by_way.head<2>().asDiagonal() * way;
  }
  by_place.topLeftCorner<2, 1>() += way.col(3);
  Eigen::Matrix<double, 3, 3> by_rest = Eigen::Matrix3d::Zero();  // yaw, scale, bias
  by_rest.topRows<2>() = way.leftCols<3>();

  // Heading: ω dt and east · tan L/(R_t + h).
  const double convergence_by_lat =
      (1 + tangent * tangent) / transverse - tangent * R.d_transverse / (transverse * transverse);
  Eigen::RowVector3d yaw_by_place(rate_by_north * (dt + convergence * arc.by_rate[1]) +
                                      e * convergence_by_lat / meridian,
                                  0, e * convergence / transverse);
  moved.J.topLeftCorner<3, 3>() = is_ecef_ ? Eigen::Matrix3d(C_en * by_place * C_en.transpose()) : by_place;
  moved.J.topLeftCorner<3, 3>() += Eigen::Matrix3d::Identity();
  moved.J.topRightCorner<3, 3>() = is_ecef_ ? Eigen::Matrix3d(C_en * by_rest) : by_rest;
  moved.J.bottomLeftCorner<1, 3>() = is_ecef_ ? Eigen::RowVector3d(yaw_by_place * C_en.transpose()) : yaw_by_place;
  moved.J(3, 3) = 1 + convergence * arc.by_yaw[1];
  moved.J(3, 4) = -convergence * speed / (1 + scale) * arc.by_speed[1];
  moved.J(3, 5) = -dt - convergence * arc.by_rate[1];
}

/// Of (position, heading), position in its own axes.
Eigen::Matrix4d PlanarOdometry::noise(const Parts& parts, const InputSample& sample) const {
  const double speed = std::abs(parts.speed);
  PlanarNoise densities{S_speed_ + S_distance_ * speed, S_side_ * speed, S_yaw_ + S_turn_ * std::abs(parts.rate)};
  if (sample.bridges) {
    densities.speed += squared(bridge_acceleration_ * parts.dt) * parts.dt;
    densities.yaw += squared(bridge_rate_) * parts.dt;
  }
  const Eigen::Matrix3d planar = arc_noise(parts.arc, densities, parts.speed, parts.dt);
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();
  Q.topLeftCorner<2, 2>() = planar.topLeftCorner<2, 2>();
  Q(2, 2) = S_height_ * speed * parts.dt;
  Q.topRightCorner<2, 1>() = planar.topRightCorner<2, 1>();
  Q.bottomLeftCorner<1, 2>() = planar.bottomLeftCorner<1, 2>();
  Q(3, 3) = planar(2, 2);
  if (!is_ecef_) return Q;
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
  turn.topLeftCorner<3, 3>() = parts.C_en;
  const Eigen::Matrix4d turned = turn * Q * turn.transpose();
  return 0.5 * (turned + turned.transpose());
}

Result PlanarOdometry::propagate(const ProcessInput& in, ProcessOutput& out) const {
  Pose pose{in.x[position_].as<3>(), in.x[heading_][0]};
  const double scale = scale_.is_bound() ? in.x[scale_][0] : 0.0, bias = bias_.is_bound() ? in.x[bias_][0] : 0.0;
  if (!(scale > -0.9)) return Result::failed("the scale factor error of the speed is -0.9 or less");
  Jacobian J = Jacobian::Zero();
  J.topLeftCorner<4, 4>().setIdentity();
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();
  for (const InputSample& sample : in.step.samples) {
    constexpr double fastest = 1e5, most_turn = 1e4;  // m/s, rad/s: in range for any vehicle, and for what follows
    const Reading reading = read(sample);
    if (!(std::abs(reading.speed) < fastest && std::abs(reading.rate) < most_turn))
      return Result::failed("speed or yaw rate is beyond that of any vehicle");
    Moved moved = move(pose, scale, bias, sample);
    if (out.phi || out.Qd) {
      differentiate(moved.parts, moved);
      const Eigen::Matrix4d F = moved.J.leftCols<4>();
      Jacobian next = F * J;
      next.rightCols<2>() += moved.J.rightCols<2>();
      J = next;
      const Eigen::Matrix4d carried = F * Q * F.transpose();
      Q = 0.5 * (carried + carried.transpose()) + noise(moved.parts, sample);
    }
    pose = moved.pose;
  }
  out.x[position_].as<3>() = pose.position;
  out.x[heading_][0] = pose.yaw;
  write(J, Q, out);
  return Result::ok();
}

void PlanarOdometry::write(const Jacobian& J, const Eigen::Matrix4d& Q, ProcessOutput& out) const {
  if (out.phi) {
    out.phi[phi_pp_].as<3, 3>() = J.topLeftCorner<3, 3>();
    out.phi[phi_ph_].as<3, 1>() = J.block<3, 1>(0, 3);
    out.phi[phi_hp_].as<1, 3>() = J.block<1, 3>(3, 0);
    out.phi[phi_hh_].as<1, 1>() = J.block<1, 1>(3, 3);
    if (const BlockView phi = out.phi[phi_ps_]) phi.as<3, 1>() = J.block<3, 1>(0, 4);
    if (const BlockView phi = out.phi[phi_hs_]) phi.as<1, 1>() = J.block<1, 1>(3, 4);
    if (const BlockView phi = out.phi[phi_pb_]) phi.as<3, 1>() = J.block<3, 1>(0, 5);
    if (const BlockView phi = out.phi[phi_hb_]) phi.as<1, 1>() = J.block<1, 1>(3, 5);
  }
  if (out.Qd) {
    out.Qd[q_pp_].as<3, 3>() = Q.topLeftCorner<3, 3>();
    out.Qd[q_ph_].as<3, 1>() = Q.topRightCorner<3, 1>();
    out.Qd[q_hh_].as<1, 1>() = Q.bottomRightCorner<1, 1>();
  }
}

}  // namespace binnacle::odometry
