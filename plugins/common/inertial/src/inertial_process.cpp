// SPDX-License-Identifier: Apache-2.0
// A process model that navigates by an inertial sensor, whatever its error model.
#include "inertial/inertial_process.hpp"

#include <span>
#include <string>
#include <utility>

#include "attitude/choice.hpp"
#include "binnacle/view.hpp"
#include "inertial/sample_group.hpp"

namespace binnacle::inertial {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using strapdown::NoiseBlocks;
using strapdown::Order;
using strapdown::TransitionBlocks;

/// Ports, in the order of the spec and of the error state.
enum Place { position, velocity, attitude, gyro_bias, accel_bias, gyro_scale, accel_scale };
constexpr std::array place_names = {"position",   "velocity",   "attitude",   "gyro_bias",
                                    "accel_bias", "gyro_scale", "accel_scale"};

constexpr double least_cos_lat = 1e-5;                          // 64 m from a pole
constexpr Time longest_statement = 2 * nanoseconds_per_second;  // for how long a statement that it stands is believed
constexpr const char* near_pole =
    "north-east-down axes are not defined at a pole, and the position is within 64 m of one";

/// Where the blocks of the error model stand. Those whose least order is the second vanish in a first-order transition.
struct TransitionPlace {
  Place to, from;
  Matrix3d TransitionBlocks::*block;
  Order least_order;
};
constexpr TransitionPlace transition_places[] = {
    {position, position, &TransitionBlocks::p_p, Order::first},
    {position, velocity, &TransitionBlocks::p_v, Order::first},
    {position, attitude, &TransitionBlocks::p_phi, Order::second},
    {position, accel_bias, &TransitionBlocks::p_ba, Order::second},
    {position, accel_scale, &TransitionBlocks::p_sa, Order::second},
    {velocity, position, &TransitionBlocks::v_p, Order::first},
    {velocity, velocity, &TransitionBlocks::v_v, Order::first},
    {velocity, attitude, &TransitionBlocks::v_phi, Order::first},
    {velocity, gyro_bias, &TransitionBlocks::v_bg, Order::second},
    {velocity, accel_bias, &TransitionBlocks::v_ba, Order::first},
    {velocity, gyro_scale, &TransitionBlocks::v_sg, Order::second},
    {velocity, accel_scale, &TransitionBlocks::v_sa, Order::first},
    {attitude, position, &TransitionBlocks::phi_p, Order::first},
    {attitude, velocity, &TransitionBlocks::phi_v, Order::first},
    {attitude, attitude, &TransitionBlocks::phi_phi, Order::first},
    {attitude, gyro_bias, &TransitionBlocks::phi_bg, Order::first},
    {attitude, accel_bias, &TransitionBlocks::phi_ba, Order::second},
    {attitude, gyro_scale, &TransitionBlocks::phi_sg, Order::first},
    {attitude, accel_scale, &TransitionBlocks::phi_sa, Order::second},
};

/// Q to first order is A dt and G dt alone.
struct NoisePlace {
  Place to, from;
  Matrix3d NoiseBlocks::*block;
  Order least_order;
};
constexpr NoisePlace noise_places[] = {
    {position, position, &NoiseBlocks::p_p, Order::second},   {position, velocity, &NoiseBlocks::p_v, Order::second},
    {position, attitude, &NoiseBlocks::p_phi, Order::second}, {velocity, velocity, &NoiseBlocks::v_v, Order::first},
    {velocity, attitude, &NoiseBlocks::v_phi, Order::second}, {attitude, attitude, &NoiseBlocks::phi_phi, Order::first},
};

/// Where no sensor error is plugged in.
strapdown::InputSensitivity no_sensitivity() {
  return {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
}

/// Of an attitude that moves alone: itself and the gyros.
constexpr bool turns_attitude(Place from) { return from == attitude || from == gyro_bias || from == gyro_scale; }

FieldSpec increment_field(std::string name, std::string unit, std::string text) {
  return field::increment(std::move(name), std::move(unit)).about(std::move(text));
}

/// Φ and Q of several updates, as matrices, which are not even zeroed in steps of one; those leave this alone.
class Folded {
 public:
  explicit Folded(bool has_sensor_errors) : has_sensor_errors_(has_sensor_errors) {}
  bool is_begun() const { return is_begun_; }
  [[gnu::noinline]] void then(const Linearized& sample) {
    if (!std::exchange(is_begun_, true)) rows_.setIdentity(), Q_.setZero();
    const Rows next = assemble(sample.transition);
    const Square phi = next.leftCols<9>();
    rows_ = phi.lazyProduct(rows_).eval();
    rows_.rightCols<12>() += next.rightCols<12>();
    const Square phi_Q = phi.lazyProduct(Q_);
    Q_ = phi_Q.lazyProduct(phi.transpose()) + assemble(sample.noise);
  }
  Linearized blocks() const {
    Linearized l;
    for (const auto& place : transition_places)
      l.transition.*place.block = rows_.block<3, 3>(3 * place.to, 3 * place.from);
    for (const auto& place : noise_places) l.noise.*place.block = Q_.block<3, 3>(3 * place.to, 3 * place.from);
    return l;
  }

 private:
  using Rows = Eigen::Matrix<double, 9, 21>;  // of Φ, columns by port
  using Square = Eigen::Matrix<double, 9, 9>;

  Rows assemble(const TransitionBlocks& blocks) const {
    Rows rows = Rows::Zero();
    for (const auto& place : transition_places)
      if (place.from <= attitude || has_sensor_errors_)
        rows.block<3, 3>(3 * place.to, 3 * place.from) = blocks.*place.block;
    return rows;
  }
  static Square assemble(const NoiseBlocks& blocks) {
    Square Q;
    for (const auto& place : noise_places) {
      Q.block<3, 3>(3 * place.to, 3 * place.from) = blocks.*place.block;
      Q.block<3, 3>(3 * place.from, 3 * place.to) = (blocks.*place.block).transpose();
    }
    return Q;
  }

  Rows rows_;
  Square Q_;
  bool has_sensor_errors_;
  bool is_begun_ = false;
};

}  // namespace

void InertialProcess::describe(ComponentSpec& spec) {
  spec.parameters = {
      parameter::vector("gyro_noise", "rad/s/sqrt(Hz)", 3)
          .at_least(0)
          .plausible(1e-9, 1e-2)
          .required()
          .about("angle random walk per body axis, root of the power spectral density"),
      parameter::vector("accel_noise", "m/s^2/sqrt(Hz)", 3)
          .at_least(0)
          .plausible(1e-8, 1)
          .required()
          .about("velocity random walk per body axis, root of the power spectral density"),
      parameter::choice("order", {"first", "second"})
          .defaults("\"second\"")
          .about("order of the transition matrix over a step: first: I + F dt; second: with F^2 dt^2/2; the same order "
                 "for Q"),
      attitude::choice_parameter(),
      parameter::object("bridge", {parameter::number("acceleration", "m/s^2")
                                       .defaults("\"1 m/s^2\"")
                                       .at_least(0)
                                       .about("unknown acceleration over ground during the hole, 1-sigma per axis"),
                                   parameter::vector("rate", "rad/s", 3)
                                       .defaults("\"5 deg/s\"")
                                       .at_least(0)
                                       .about("unknown angular rate during the hole, 1-sigma per body axis, besides "
                                              "the rates just before and after it")})
          .defaults("{}")
          .about("additional noise of a step that bridges a hole in the input"),
  };
  spec.ports = {
      advances("position", "position").about("position of the inertial sensor"),
      advances("velocity", "velocity.ned").about("velocity of the inertial sensor over ground"),
      advances("attitude", "attitude").about("attitude of the sensor's (body) axes"),
      reads("gyro_bias", "vector:3:rad/s").optional().about("gyro bias: measured = (1 + scale) true + bias"),
      reads("accel_bias", "vector:3:m/s^2").optional().about("accelerometer bias: measured = (1 + scale) true + bias"),
      reads("gyro_scale", "vector:3:1").optional().about("scale factor error of the gyros"),
      reads("accel_scale", "vector:3:1").optional().about("scale factor error of the accelerometers")};
  for (const char* axis : {"x", "y", "z"})
    spec.fields.push_back(increment_field(std::string("w") + axis, "rad",
                                          "integral of the angular rate with respect to inertial space, body axes"));
  for (const char* axis : {"x", "y", "z"})
    spec.fields.push_back(increment_field(std::string("f") + axis, "m/s", "integral of the specific force, body axes"));
  spec.inputs = {input("standing", {field::level("standing", "1").about("1 while the vehicle stands")})
                     .optional()
                     .about("a stationary detector's state: while it stands the error model takes gravity for the "
                            "specific force, without the noise of the samples")};
}

InertialProcess::InertialProcess(const Binding& binding, ErrorModel model)
    : model_(model), order_(binding.parameters().text("order") == "first" ? Order::first : Order::second) {
  algorithm_ = attitude::read_choice(binding);
  density_.gyro = binding.parameters().vector("gyro_noise").cwiseAbs2();
  density_.accel = binding.parameters().vector("accel_noise").cwiseAbs2();
  const Parameters bridge = binding.parameters().object("bridge");
  bridge_acceleration_ = bridge.number("acceleration");
  bridge_rate_ = bridge.vector("rate");
  for (std::size_t i = 0; i < ports_.size(); ++i) ports_[i] = binding.port(place_names[i]);
  for (const Place place : {gyro_bias, accel_bias, gyro_scale, accel_scale})
    has_sensor_errors_ = has_sensor_errors_ || ports_[place].is_bound();
  has_position_errors_ = binding.block("position").is_estimated;
  fields_ = {binding.fields("wx", "wy", "wz"), binding.fields("fx", "fy", "fz")};
  standing_ = binding.input("standing");
  is_standing_ = binding.field(standing_, "standing");
  memory_ = declaration_.keeps<SampleMemory>();
  declare_transition();
  declare_noise();
}

strapdown::SensorErrors InertialProcess::sensor_errors(const PortValues& x) const {
  strapdown::SensorErrors errors;
  if (const auto bias = x[ports_[gyro_bias]]) errors.gyro_bias = bias.as<3>();
  if (const auto bias = x[ports_[accel_bias]]) errors.accel_bias = bias.as<3>();
  if (const auto scale = x[ports_[gyro_scale]]) errors.gyro_scale = scale.as<3>();
  if (const auto scale = x[ports_[accel_scale]]) errors.accel_scale = scale.as<3>();
  return errors;
}

void InertialProcess::declare_transition() {
  for (const auto& place : transition_places) {
    const bool vanishes = (place.least_order == Order::second && order_ == Order::first) ||
                          (model_.attitude_moves_alone && place.to == attitude && !turns_attitude(place.from));
    if (vanishes) continue;
    const PhiBlock block = declaration_.couples(ports_[place.to], ports_[place.from]);
    const bool is_read = has_position_errors_ || (place.to != position && place.from != position);
    if (block.is_declared() && is_read) transition_.push_back({block, place.block, place.to == place.from});
  }
}

void InertialProcess::declare_noise() {
  for (const auto& place : noise_places) {
    if (place.least_order == Order::second && order_ == Order::first) continue;
    const QBlock block = declaration_.adds_noise(ports_[place.to], ports_[place.from]);
    if (has_position_errors_ || place.to != position) noise_.push_back({block, place.block});
  }
}

// An acceleration a over ground, unknown and constant over a hole of length T, leaves a velocity error of variance
// (a T)², as white noise of density a² T does; that adds up right where measurements cut the hole into pieces. A rate r
// likewise: density G = r² T.
//
// The specific force f is held in body axes, so noise of the rate turns it, as an aircraft's lift turns with it. A car
// that rolls goes on as it was, and gravity turns in its axes: its specific force differs from the one held by f × r t,
// t into the hole (or to its end, where f is that after it). Which of them the vehicle is, is not known, so this too is
// an acceleration that it may have. Its mean square over the hole is K r² Kᵀ T²/3, K = [f×]: density K G Kᵀ T²/3.
strapdown::NoiseDensity InertialProcess::density(const Step& step) const {
  strapdown::NoiseDensity density = density_;
  if (!step.bridges || step.samples.empty()) return density;
  const double hole = seconds(step.samples.front().whole_t1 - step.samples.front().whole_t0);
  density.gyro += bridge_rate_.cwiseAbs2() * hole;
  density.accel.array() += bridge_acceleration_ * bridge_acceleration_ * hole;
  density.turned_squared = hole * hole / 3.0;
  return density;
}

// The noise of an accelerometer's sample enters the velocity, and by −[f×] in Φ the attitude's coupling to it as well:
// the two together look like information about the heading. At rest f is known to be −g.
bool InertialProcess::stands(const ProcessInput& in) const {
  if (!standing_.is_bound()) return false;
  const SampleView& state = in.auxiliary[standing_];
  return state.available && state[is_standing_] > 0.5 && in.step.t1 - state.t <= longest_statement;
}

Result InertialProcess::propagate(const ProcessInput& in, ProcessOutput& out) const {
  const strapdown::NoiseDensity noise_density = density(in.step);
  const strapdown::SensorErrors errors = sensor_errors(in.x);
  strapdown::Navigation nav{in.x[ports_[position]].as<3>(), in.x[ports_[velocity]].as<3>(),
                            in.x[ports_[attitude]].as<4>()};
  const bool wants_errors = out.phi || out.Qd, at_rest = stands(in);
  SampleMemory remembered = in.memory[memory_];
  Folded folded(has_sensor_errors_);
  bool is_moved = false;
  for (auto rest = in.step.samples; !rest.empty();) {
    SampleGroup group;
    if (!group.take(rest, algorithm_.samples(), fields_)) return Result::failed(SampleGroup::implausible);
    if (group.count() == 0) continue;
    const strapdown::BodyMotion body = motion(group, errors, remembered);
    strapdown::Step advanced = strapdown::step(nav, body, algorithm_.update());
    if (!(advanced.mid.cos_lat > least_cos_lat)) return Result::failed(near_pole);
    if (!wants_errors) {
      nav = advanced.nav;
      continue;
    }
    if (at_rest) advanced.mid.f_n << 0.0, 0.0, -advanced.mid.g;
    const strapdown::InputSensitivity input =
        has_sensor_errors_ ? input_sensitivity(correct(group.sum(), errors), errors) : no_sensitivity();
    const bool is_alone = !is_moved && rest.empty();
    const bool is_whole = has_position_errors_ || !is_alone;
    const Linearized linearized{model_.transition({nav, advanced, input, order_, has_sensor_errors_, is_whole}),
                                strapdown::process_noise(advanced.mid, noise_density, is_whole)};
    nav = advanced.nav;
    if (is_alone) {
      write(linearized, out);
    } else {
      folded.then(linearized);
    }
    is_moved = true;
  }
  in.memory[memory_] = remembered;
  out.x[ports_[position]].as<3>() = nav.lla;
  out.x[ports_[velocity]].as<3>() = nav.v_n;
  out.x[ports_[attitude]].as<4>() = nav.q_nb;
  if (!is_moved) {
    write_identity(out);
  } else if (folded.is_begun()) {
    write(folded.blocks(), out);
  }
  return Result::ok();
}

/// Without errors to take off it is what was measured, to the bit.
strapdown::Increment InertialProcess::corrected(const strapdown::Increment& measured,
                                                const strapdown::SensorErrors& errors) const {
  return has_sensor_errors_ ? correct(measured, errors) : measured;
}

strapdown::MeanRates InertialProcess::corrected(const strapdown::MeanRates& measured,
                                                const strapdown::SensorErrors& errors) const {
  if (!(measured.dt > 0.0)) return {};
  if (!has_sensor_errors_) return measured;
  const strapdown::Increment rates = correct({1.0, measured.omega, measured.f, 0.0, 0.0}, errors);
  return {measured.dt, rates.dtheta, rates.dv};
}

strapdown::BodyMotion InertialProcess::motion(const SampleGroup& group, const strapdown::SensorErrors& errors,
                                              SampleMemory& remembered) const {
  if (group.count() == 1) {
    // Through the rates held over a hole and those measured before it no line goes that means anything.
    const strapdown::Previous neighbours =
        group.sample(0).bridges ? strapdown::Previous{} : remembered.before(group.sample(0));
    const strapdown::Increment increment = corrected(group.measured(0), errors);
    const strapdown::MeanRates neighbour =
        corrected(increment.sample_offset > 0.0 ? neighbours.before : neighbours.last, errors);
    remembered.remember(neighbours, group.measured(0), group.sample(0));
    return body_motion(increment, algorithm_.uses_previous() ? neighbour : strapdown::MeanRates{}, algorithm_);
  }
  std::array<strapdown::Increment, attitude::most_samples> increments;
  for (std::size_t i = 0; i < group.count(); ++i) {
    increments[i] = corrected(group.measured(i), errors);
    remembered.remember(remembered.before(group.sample(i)), group.measured(i), group.sample(i));
  }
  return body_motion(std::span(increments).first(group.count()), algorithm_);
}

void InertialProcess::write(const Linearized& linearized, const ProcessOutput& out) const {
  if (out.phi)
    for (const auto& [place, block, is_own] : transition_) out.phi[place].as<3, 3>() = linearized.transition.*block;
  if (out.Qd)
    for (const auto& [place, block] : noise_) out.Qd[place].as<3, 3>() = linearized.noise.*block;
}

void InertialProcess::write_identity(const ProcessOutput& out) const {
  if (out.phi)
    for (const auto& [place, block, is_own] : transition_)
      is_own ? out.phi[place].set_identity() : out.phi[place].set_zero();
  if (out.Qd)
    for (const auto& [place, block] : noise_) out.Qd[place].set_zero();
}

}  // namespace binnacle::inertial
