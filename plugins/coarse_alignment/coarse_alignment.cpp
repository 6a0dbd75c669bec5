// SPDX-License-Identifier: Apache-2.0
// The coarse_alignment transform: the first attitude, by levelling at rest and one of three ways to a heading.
#include "coarse_alignment.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::coarse_alignment {

namespace sd = strapdown;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

constexpr Time longest_hole = nanoseconds_per_second / 10;  // between IMU samples, bridged by the one after it
constexpr double least_cos_pitch = 0.05;                    // below it roll and yaw are hardly told apart

double squared(double x) { return x * x; }

double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

Vector4d about_down(double angle) { return {std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle)}; }

/// Attitude at rest, yaw to be given: f_b = C_bn (0, 0, −g), hence roll = atan2(−f_y, −f_z) and
/// pitch = atan2(f_x, √(f_y² + f_z²)) (Groves, Principles of GNSS, Inertial, and Multisensor ..., 2nd ed.,
/// section 5.6.2).
Vector4d levelled(const Vector3d& f_b, double yaw) {
  return sd::quaternion_from_euler(
      {std::atan2(-f_b.y(), -f_b.z()), std::atan2(f_b.x(), std::hypot(f_b.y(), f_b.z())), yaw});
}

/// φ_D = η + c_N φ_N + c_E φ_E where η is the error of the Euler angle yaw: the heading of the x axis, tilted by φ_N and
/// φ_E, changes by tan(pitch) (cos ψ φ_N + sin ψ φ_E) + φ_D.
Eigen::Vector2d coupling_of_yaw(const Vector3d& euler) {
  return -std::tan(euler.y()) * Eigen::Vector2d(std::cos(euler.z()), std::sin(euler.z()));
}

}  // namespace

/// Attitudes are quaternions body → level axes (x, y horizontal, z down), and those become north, east, down once the
/// heading is known. Flags are 0 or 1.
struct State {
  RestWindow window;
  // the last IMU sample
  Time t_imu;
  double rate[3];
  double turned;  // ∫ |rate − rest rate| dt since the start, rad
  // the last levelling
  std::int64_t is_levelled;
  Time t_level;
  double q[4];          // now
  double q_rest[4];     // when it was levelled
  double rest_rate[3];  // mean rate at rest: gyro bias and earth rate
  double rate_variance;
  double tilt_variance;
  double turned_at_level;
  // heading
  std::int64_t is_headed;
  Time t_heading;
  double heading_variance;  // of η
  double coupling[2];       // c
  double turned_at_heading;
  // latest GNSS latitude
  std::int64_t has_latitude;
  double latitude;
  // output
  std::int64_t was_solved;
  Time t_emitted;
  // for messages
  RestFindings rest;
  std::int64_t samples, holes, without_interval, rests;
  double spacing;    // of the last two IMU samples, s
  double top_speed;  // of GNSS velocities, m/s

  Eigen::Map<Vector4d, Eigen::Unaligned> attitude() { return Eigen::Map<Vector4d, Eigen::Unaligned>(q); }
  Vector3d corrected_rate() const { return {rate[0] - rest_rate[0], rate[1] - rest_rate[1], rate[2] - rest_rate[2]}; }
  void forget_attitude() {
    window.clear();
    is_levelled = is_headed = 0;
  }
};

namespace {

/// Where the heading comes from.
std::vector<ParameterSpec> heading_parameters() {
  using namespace parameter;
  return {choice("heading", {"given", "course", "gyrocompass"})
              .required()
              .about("source of the heading: the parameter yaw; the direction of the GNSS velocity, for a vehicle that "
                     "moves forward along its x axis; the earth rate, for gyros far better than 15 deg/h"),
          number("yaw", "rad").about("heading of the x axis at the first rest, for \"given\""),
          number("sigma_heading", "rad")
              .at_least(0)
              .defaults("\"1 deg\"")
              .about("1-sigma of the given yaw, or between course and x axis"),
          number("latitude", "rad")
              .at_least(-M_PI / 2)
              .at_most(M_PI / 2)
              .about("latitude for the earth rate; default: lat of gnss, if present")};
}

/// What counts as rest.
std::vector<ParameterSpec> rest_parameters() {
  using namespace parameter;
  return {time("duration")
              .above(0)
              .defaults("\"2 s\"")
              .about("duration of rest that is averaged; the alignment waits an eighth longer before it uses it"),
          number("max_specific_force_sd", "m/s^2")
              .above(0)
              .defaults("0.15")
              .about("at rest: largest standard deviation of the samples, per axis"),
          number("max_rate_sd", "rad/s")
              .above(0)
              .defaults("\"0.5 deg/s\"")
              .about("at rest: largest standard deviation of the samples, per axis"),
          number("max_rate", "rad/s")
              .above(0)
              .defaults("\"3 deg/s\"")
              .about("at rest: largest mean rate, including the gyro bias"),
          number("max_gravity_error", "m/s^2")
              .above(0)
              .defaults("0.5")
              .about("at rest: largest difference between the length of the mean specific force and 9.80665 m/s^2"),
          number("max_speed", "m/s").above(0).defaults("0.3").about("at rest: largest GNSS speed")};
}

/// When the course is taken, and how long an attitude is carried on.
std::vector<ParameterSpec> course_parameters() {
  using namespace parameter;
  return {number("min_speed", "m/s").above(0).defaults("3").about("least horizontal speed for a course"),
          number("max_turn_rate", "rad/s").above(0).defaults("\"10 deg/s\"").about("largest turn rate for a course"),
          number("slip_lever_arm", "m")
              .formerly("slip_arm")
              .at_least(0)
              .defaults("1.5")
              .about("1-sigma distance from the antenna to the point that does not slip sideways; multiplied by turn "
                     "rate / speed it is an error of the course"),
          number("velocity_sd", "m/s")
              .above(0)
              .about("1-sigma of the GNSS velocity, per axis; default: as the channel reports it, else 0.2"),
          time("max_coast")
              .above(0)
              .defaults("\"120 s\"")
              .about("longest time for which the gyros propagate the attitude after a rest"),
          time("every").above(0).about(
              "time between repeated outputs, propagated by the gyros between rests; default: only one output")};
}

/// Errors of the IMU.
std::vector<ParameterSpec> error_parameters() {
  using namespace parameter;
  return {number("accelerometer_bias", "m/s^2")
              .at_least(0)
              .defaults("\"10 mg\"")
              .about("1-sigma per axis, from which the sigma of the tilt is computed"),
          number("gyro_bias", "rad/s")
              .at_least(0)
              .about("1-sigma per axis, from which the sigma of a gyrocompassed heading is computed; required for it"),
          number("gyro_drift", "rad/s")
              .at_least(0)
              .defaults("\"0.01 deg/s\"")
              .about("1-sigma per axis of the later change of the bias from the mean at rest"),
          number("gyro_misalignment", "1")
              .at_least(0)
              .defaults("0.005")
              .about("1-sigma of scale factor and cross-axis errors; multiplied by the angle turned after the rest")};
}

}  // namespace

ComponentSpec CoarseAlignment::spec() {
  ComponentSpec spec;
  spec.type = "coarse_alignment";
  spec.summary = "initial attitude of an IMU: levelled at rest, with a given heading, the course, or gyrocompassing";
  spec.source =
      "P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., "
      "section 5.6.2";
  std::vector<FieldSpec> of_imu;
  for (const char* name : {"wx", "wy", "wz"})
    of_imu.push_back(field::rate(name, "rad/s").about("mean over the sample, body axes"));
  for (const char* name : {"fx", "fy", "fz"})
    of_imu.push_back(field::rate(name, "m/s^2").about("mean over the sample, body axes"));
  spec.inputs = {
      input("imu", std::move(of_imu)).about("angular rate and specific force, body axes (forward, right, down)"),
      input("gnss",
            {field::level("vn", "m/s").about("north velocity"), field::level("ve", "m/s").about("east velocity"),
             field::level("lat", "rad").optional().about("latitude, for the earth rate"),
             field::level("velocity_sd_n", "m/s").optional().about("standard deviation of vn"),
             field::level("velocity_sd_e", "m/s").optional().about("standard deviation of ve")})
          .optional()
          .about("velocity, for the course and for the detection of rest")};
  for (const auto& group : {heading_parameters(), rest_parameters(), course_parameters(), error_parameters()})
    spec.parameters.insert(spec.parameters.end(), group.begin(), group.end());
  spec.example = R"({
  "inputs": { "imu": "imu", "gnss": "gnss" },
  "heading": "course",
  "duration": "2 s",
  "accelerometer_bias": "10 mg"
})";
  return spec;
}

CoarseAlignment::CoarseAlignment(const Binding& binding) {
  const Parameters& p = binding.parameters();
  const std::string& heading = p.text("heading");
  Settings& s = settings_;
  s.heading = heading == "given" ? Heading::given : heading == "course" ? Heading::course : Heading::gyrocompass;
  if (s.heading == Heading::given && !p.has("yaw")) throw ComponentError("a given heading needs a yaw", "/yaw");
  if (s.heading == Heading::gyrocompass && !p.has("gyro_bias"))
    throw ComponentError("gyrocompassing needs the gyro_bias (1-sigma) that limits it", "/gyro_bias");
  if (p.has("yaw")) s.yaw = p.number("yaw");
  s.sigma_heading = p.number("sigma_heading");
  if (p.has("latitude")) s.latitude = p.number("latitude");
  s.rest = {seconds(p.time("duration")), p.number("max_specific_force_sd"), p.number("max_rate_sd"),
            p.number("max_rate"), p.number("max_gravity_error")};
  s.max_speed = p.number("max_speed");
  s.min_speed = p.number("min_speed");
  s.max_turn_rate = p.number("max_turn_rate");
  s.slip_lever_arm = p.number("slip_lever_arm");
  if (p.has("velocity_sd")) s.velocity_sd = p.number("velocity_sd");
  s.max_coast = p.time("max_coast");
  if (p.has("every")) s.every = p.time("every");
  s.accelerometer_bias = p.number("accelerometer_bias");
  if (p.has("gyro_bias")) s.gyro_bias = p.number("gyro_bias");
  s.gyro_drift = p.number("gyro_drift");
  s.gyro_misalignment = p.number("gyro_misalignment");
  if (s.min_speed <= s.max_speed) throw ComponentError("a course needs more speed than rest allows", "/min_speed");

  imu_ = binding.input("imu");
  gnss_ = binding.input("gnss");
  w_ = binding.fields(imu_, "wx", "wy", "wz");
  f_ = binding.fields(imu_, "fx", "fy", "fz");
  velocity_ = binding.fields(gnss_, "vn", "ve");
  velocity_sd_ = binding.fields(gnss_, "velocity_sd_n", "velocity_sd_e");
  latitude_ = binding.field(gnss_, "lat");
  declare_channels();
  state_ = declaration_.keeps<State>();
}

void CoarseAlignment::declare_channels() {
  ChannelDeclaration attitude;
  attitude_ = attitude.carries(field::level("roll", "rad").about("Euler angles z-y-x, navigation to body"),
                               field::level("pitch", "rad"), field::level("yaw", "rad"));
  attitude.covariance = {{"north", "rad"}, {"east", "rad"}, {"down", "rad"}};
  attitude_channel_ = declaration_.emits(std::move(attitude));
  if (settings_.heading == Heading::gyrocompass) return;  // there the mean rate is what the heading is made of
  const auto rate = [](const char* axis) {
    return field::level(axis, "rad/s").about("mean rate at rest, earth rate removed where known");
  };
  ChannelDeclaration bias("gyro_bias");
  gyro_bias_ = bias.carries(rate("x"), rate("y"), rate("z"));
  bias.covariance = {{"x", "rad/s"}, {"y", "rad/s"}, {"z", "rad/s"}};
  gyro_bias_channel_ = declaration_.emits(std::move(bias));
}

void CoarseAlignment::initialise(std::uint64_t /*seed*/, const MemoryView& memory) const {
  memory[state_].t_imu = no_time;
}

void CoarseAlignment::on(const TransformInput& in, Emitter& emitter) const {
  State& state = in.memory[state_];
  if (state.was_solved && !settings_.every) return;
  if (in.from == imu_) on_imu(in.sample, state, emitter);
  if (in.from == gnss_) on_gnss(in.sample, state, emitter);
}

void CoarseAlignment::on_imu(const SampleView& sample, State& state, Emitter& emitter) const {
  const Vector3d rate = sample[w_], force = sample[f_];
  if (!rate.allFinite() || !force.allFinite()) return;
  const Time before = state.t_imu;
  state.t_imu = sample.t;
  Eigen::Map<Vector3d>(state.rate) = rate;
  ++state.samples;
  state.without_interval += sample.t0 == no_time;
  if (before != no_time) {
    state.spacing = seconds(sample.t - before);
    state.holes += sample.t0 != no_time && sample.t0 - before > longest_hole;
  }
  if (before == no_time || sample.t0 == no_time || sample.t0 - before > longest_hole || sample.t <= before)
    return state.forget_attitude();

  const double dt = seconds(sample.t - before);
  if (state.is_levelled) {
    const Vector3d angle = state.corrected_rate() * dt;
    state.attitude() = sd::quaternion_normalised(sd::quaternion_product(state.attitude(), sd::quaternion_exp(angle)));
    state.turned += angle.norm();
  }
  if (state.window.add(settings_.rest, dt, rate, force, state.rest) == RestWindow::Event::at_rest) {
    ++state.rests;
    level(sample.t, state);
  }
  emit(sample.t, state, emitter);
}

/// Takes roll and pitch from the mean specific force at rest; yaw goes on, or is given here.
void CoarseAlignment::level(Time t, State& state) const {
  const RestMeans means = state.window.means();
  const double g = means.specific_force.norm();
  if (settings_.heading == Heading::gyrocompass) {
    gyrocompass(t, means, state);
    if (!state.is_headed) return;
  } else {
    const bool is_given_now = settings_.heading == Heading::given && !state.was_solved && !state.is_headed;
    const double yaw = is_given_now        ? settings_.yaw
                       : state.is_levelled ? sd::euler_from_quaternion(state.attitude()).z()
                                           : 0.0;
    const Vector4d q = levelled(means.specific_force, yaw);
    const Vector3d euler = sd::euler_from_quaternion(q);
    if (std::cos(euler.y()) < least_cos_pitch) return;
    state.attitude() = q;
    if (is_given_now) {
      state.is_headed = 1;
      state.t_heading = t;
      state.heading_variance = squared(settings_.sigma_heading);
      Eigen::Map<Eigen::Vector2d>(state.coupling) = coupling_of_yaw(euler);
      state.turned_at_heading = state.turned;
    }
  }
  state.is_levelled = 1;
  state.t_level = t;
  std::copy_n(state.q, 4, state.q_rest);
  Eigen::Map<Vector3d>(state.rest_rate) = means.rate;
  state.rate_variance = means.rate_variance;
  // φ_N = b_E/g, φ_E = −b_N/g in level axes: the same variance about both.
  state.tilt_variance = (squared(settings_.accelerometer_bias) + means.specific_force_variance) / squared(g);
  state.turned_at_level = state.turned;
}

/// Down from the specific force; east = down × earth rate, since ω_ie = Ω (cos L, 0, −sin L) (gyrocompassing in
/// Groves, section 5.6.2).
/// With biases b^a, b^g in navigation axes the solution has φ_N = b^a_E/g, φ_E = −b^a_N/g,
/// φ_D = b^g_E/(Ω cos L) − tan L φ_N, from ω_E = 0 and f_N = f_E = 0 in the solved axes.
void CoarseAlignment::gyrocompass(Time t, const RestMeans& means, State& state) const {
  const auto lat = latitude(state);
  if (!lat) return;
  const Vector3d down = -means.specific_force.normalized();
  const Vector3d east_rate = down.cross(means.rate);  // length Ω cos L
  const double horizontal = sd::wgs84::omega_ie * std::cos(*lat);
  const double variance = squared(settings_.gyro_bias) + means.rate_variance;
  // A horizontal rate that is not the earth's: turning, or gyros that cannot do it.
  const double tilt = settings_.accelerometer_bias / means.specific_force.norm();
  const double leeway = 5 * (std::sqrt(variance) + sd::wgs84::omega_ie * tilt);
  if (horizontal < 3 * std::sqrt(variance) || std::abs(east_rate.norm() - horizontal) > leeway) return;
  const Vector3d east = east_rate.normalized();
  Eigen::Matrix3d C_nb;
  C_nb.row(0) = east.cross(down);
  C_nb.row(1) = east;
  C_nb.row(2) = down;
  state.attitude() = sd::quaternion_from_dcm(C_nb);
  state.is_headed = 1;
  state.t_heading = t;
  state.heading_variance = variance / squared(horizontal);
  state.coupling[0] = -std::tan(*lat);
  state.coupling[1] = 0;
  state.turned_at_heading = state.turned;
}

void CoarseAlignment::on_gnss(const SampleView& sample, State& state, Emitter& emitter) const {
  const double vn = sample[velocity_[0]], ve = sample[velocity_[1]], lat = sample[latitude_];
  if (std::isfinite(lat)) {
    state.latitude = lat;
    state.has_latitude = 1;
  }
  if (!std::isfinite(vn) || !std::isfinite(ve)) return;
  const double speed = std::hypot(vn, ve);
  state.top_speed = std::max(state.top_speed, speed);
  if (speed > settings_.max_speed) state.window.clear();
  if (settings_.heading != Heading::course || !state.is_levelled || speed < settings_.min_speed) return;
  const Time age = sample.t - state.t_imu;
  if (age < 0 || age > longest_hole || sample.t - state.t_level > settings_.max_coast) return;

  const Vector3d rate = state.corrected_rate();
  const Vector4d q = sd::quaternion_product(state.attitude(), sd::quaternion_exp(rate * seconds(age)));
  const Vector3d euler = sd::euler_from_quaternion(q);
  const double turn_rate = (sd::dcm_from_quaternion(q) * rate).z();
  if (std::abs(turn_rate) > settings_.max_turn_rate || std::cos(euler.y()) < least_cos_pitch) return;
  const double variance = course_variance(sample, turn_rate);
  const double coasted = seconds(sample.t - state.t_heading);
  if (state.is_headed && variance > state.heading_variance + squared(settings_.gyro_drift * coasted)) return;

  const double course = std::atan2(ve, vn);
  const Vector4d turn = about_down(wrapped(course - euler.z()));
  state.attitude() = sd::quaternion_product(turn, state.attitude());
  Eigen::Map<Vector4d, Eigen::Unaligned> q_rest(state.q_rest);
  q_rest = sd::quaternion_product(turn, q_rest);
  state.is_headed = 1;
  state.t_heading = sample.t;
  state.heading_variance = variance;
  Eigen::Map<Eigen::Vector2d>(state.coupling) = coupling_of_yaw({euler.x(), euler.y(), course});
  state.turned_at_heading = state.turned;
  emit(sample.t, state, emitter);
}

/// Of the course as a heading: mounting and habit, velocity noise across the course, and slip while turning.
double CoarseAlignment::course_variance(const SampleView& sample, double turn_rate) const {
  constexpr double unreported = 0.2;  // m/s
  const double vn = sample[velocity_[0]], ve = sample[velocity_[1]];
  const double sd_n = sample[velocity_sd_[0]], sd_e = sample[velocity_sd_[1]];
  const double speed_squared = squared(vn) + squared(ve);
  double across = squared(settings_.velocity_sd.value_or(unreported));
  if (!settings_.velocity_sd && std::isfinite(sd_n) && std::isfinite(sd_e))
    across = (squared(ve * sd_n) + squared(vn * sd_e)) / speed_squared;
  return squared(settings_.sigma_heading) + (across + squared(settings_.slip_lever_arm * turn_rate)) / speed_squared;
}

std::optional<double> CoarseAlignment::latitude(const State& state) const {
  if (settings_.latitude) return settings_.latitude;
  if (state.has_latitude) return state.latitude;
  return std::nullopt;
}

void CoarseAlignment::emit(Time t, State& state, Emitter& emitter) const {
  if (!state.is_levelled || !state.is_headed || t - state.t_level > settings_.max_coast) return;
  if (state.was_solved && (!settings_.every || t - state.t_emitted < *settings_.every)) return;
  state.was_solved = 1;
  state.t_emitted = t;

  // What coasting adds about each axis: bias error and, at most, the earth rate that turned with the body; the gyros'
  // noise, of which the window has given the mean's variance over its duration; and what misalignment makes of turns.
  const double slope = state.rate_variance + squared(settings_.gyro_drift) + squared(sd::wgs84::omega_ie);
  const double noise = state.rate_variance * settings_.rest.duration;
  const auto growth = [&](Time since, double turned) {
    const double T = seconds(t - since);
    return slope * T * T + noise * T + squared(settings_.gyro_misalignment * (state.turned - turned));
  };
  const double tilt = state.tilt_variance + growth(state.t_level, state.turned_at_level);
  const double heading = state.heading_variance + growth(state.t_heading, state.turned_at_heading);

  SampleWriter& out = emitter.on(attitude_channel_);
  out.t = t;
  const Vector3d late = state.corrected_rate() * seconds(t - state.t_imu);
  const Vector4d q = sd::quaternion_product(state.attitude(), sd::quaternion_exp(late));
  out[attitude_] = sd::euler_from_quaternion(q);
  const Eigen::Map<const Eigen::Vector2d> c(state.coupling);
  auto P = out.attach_covariance().as<3, 3>();
  P.setZero();
  P.topLeftCorner<2, 2>().diagonal().setConstant(tilt);
  P.topRightCorner<2, 1>() = tilt * c;
  P.bottomLeftCorner<1, 2>() = tilt * c.transpose();
  P(2, 2) = heading + tilt * c.squaredNorm();
  emitter.emit(attitude_channel_);
  if (settings_.heading != Heading::gyrocompass) emit_gyro_bias(t, state, emitter);
}

void CoarseAlignment::emit_gyro_bias(Time t, const State& state, Emitter& emitter) const {
  Vector3d bias = Eigen::Map<const Vector3d>(state.rest_rate);
  double variance = state.rate_variance + squared(settings_.gyro_drift);
  if (const auto lat = latitude(state)) {
    const Eigen::Map<const Vector4d, Eigen::Unaligned> q_rest(state.q_rest);
    bias -= sd::dcm_from_quaternion(q_rest).transpose() * sd::omega_ie_n(*lat);
    variance += squared(sd::wgs84::omega_ie * std::cos(*lat)) * std::min(1.0, state.heading_variance);
  } else {
    variance += squared(sd::wgs84::omega_ie);
  }
  SampleWriter& out = emitter.on(gyro_bias_channel_);
  out.t = t;
  out[gyro_bias_] = bias;
  out.attach_covariance().as<3, 3>() = variance * Eigen::Matrix3d::Identity();
  emitter.emit(gyro_bias_channel_);
}

std::string CoarseAlignment::waits_for(const MemoryView& memory) const {
  const State& state = memory[state_];
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return std::string(text);
  };
  if (state.was_solved) return "";
  if (state.samples == 0) return "no sample of the IMU came";
  if (state.without_interval == state.samples) return "samples of the IMU have no interval";
  if (2 * state.holes > state.samples)
    return "samples of the IMU are " + number(state.spacing) + " s apart, and beyond " + number(seconds(longest_hole)) +
           " s there is no rest: is its time in other units?";
  if (state.rests == 0) return no_rest(state.rest, state.spacing);
  if (settings_.heading == Heading::course)
    return state.top_speed < settings_.min_speed
               ? "there was rest, but no course: the GNSS velocity never exceeded " + number(state.top_speed) +
                     " m/s (min_speed " + number(settings_.min_speed) + " m/s)"
               : "there was rest and speed, but no course within max_coast (" + number(seconds(settings_.max_coast)) +
                     " s) of the rest at a turn rate below max_turn_rate";
  return "there was rest, but no heading";
}

/// Why no stretch of samples was rest.
std::string CoarseAlignment::no_rest(const RestFindings& rest, double spacing) const {
  static constexpr const char* names[] = {"scatter of specific force", "scatter of rate", "mean rate",
                                          "difference between specific force and gravity"};
  static constexpr const char* keys[] = {"max_specific_force_sd", "max_rate_sd", "max_rate", "max_gravity_error"};
  static constexpr const char* units[] = {"m/s^2", "rad/s", "rad/s", "m/s^2"};
  if (rest.stretches == 0) return "samples of the IMU span less than a rest";
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return std::string(text);
  };
  constexpr double g = 9.80665, near = 0.1;
  const auto is_near = [&](double expected) { return std::abs(rest.specific_force - expected) < near * expected; };
  const std::string length = "the specific force is " + number(rest.specific_force) + " m/s^2 long: ";
  if (rest.failed[3] == rest.stretches && is_near(1.0)) return length + "is it in units of g?";
  if (rest.failed[3] == rest.stretches && is_near(g * spacing)) return length + "are these increments, not rates?";
  const auto worst = std::ranges::max_element(rest.failed) - rest.failed.begin();
  const auto at = static_cast<std::size_t>(worst);
  if (rest.failed[at] == 0)
    return "no rest was as long as duration, " + number(settings_.rest.duration) + " s and an eighth more";
  return std::string("the IMU was never at rest: ") + names[at] + " was at least " + number(rest.least[at]) + " " +
         units[at] + " (" + keys[at] + " " + number(RestFindings::limits_of(settings_.rest)[at]) + ")";
}

}  // namespace binnacle::coarse_alignment
