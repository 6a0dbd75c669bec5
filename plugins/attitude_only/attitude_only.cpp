// SPDX-License-Identifier: Apache-2.0
// An attitude moved by gyro increments alone.
#include "attitude_only.hpp"

#include <array>
#include <string>

#include "attitude/choice.hpp"
#include "binnacle/view.hpp"
#include "inertial/sample_group.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::attitude_only {

namespace {

using inertial::SampleGroup;
using inertial::SampleMemory;

Eigen::Vector3d rotation(const SampleGroup& group, const attitude::Algorithm& algorithm, SampleMemory& remembered) {
  const strapdown::Previous neighbours = remembered.before(group.sample(0));
  std::array<Eigen::Vector3d, attitude::most_samples> theta;
  std::array<double, attitude::most_samples> lengths;
  for (std::size_t i = 0; i < group.count(); ++i) {
    theta[i] = group.measured(i).dtheta;
    lengths[i] = group.measured(i).dt;
    remembered.remember(i == 0 ? neighbours : remembered.before(group.sample(i)), group.measured(i), group.sample(i));
  }
  if (group.count() > 1) {
    attitude::IntervalWeights storage;
    const auto& weights = algorithm.weights(std::span(lengths).first(group.count()), storage);
    return algorithm.rotation(std::span(theta).first(group.count()), weights);
  }
  if (!algorithm.uses_previous()) return theta[0];
  const strapdown::Increment& only = group.measured(0);
  const strapdown::MeanRates& neighbour = only.sample_offset > 0.0 ? neighbours.before : neighbours.last;
  return algorithm.rotation(theta[0], only.sample_dt > 0.0 ? only.sample_dt : only.dt, neighbour.omega, neighbour.dt);
}

}  // namespace

ComponentSpec AttitudeOnly::spec() {
  ComponentSpec spec;
  spec.type = "attitude_only";
  spec.summary = "An attitude propagated by gyro increments alone, in non-rotating axes.";
  spec.source = "paper 002";
  spec.parameters = {parameter::vector("gyro_noise", "rad/s/sqrt(Hz)", 3)
                         .at_least(0)
                         .plausible(1e-9, 1e-2)
                         .defaults("0")
                         .about("angle random walk per body axis, root of the power spectral density"),
                     attitude::choice_parameter()};
  spec.ports = {advances("attitude", "attitude").about("attitude of the gyros' axes")};
  for (const char* axis : {"x", "y", "z"})
    spec.fields.push_back(field::increment(std::string("w") + axis, "rad")
                              .about("integral of the angular rate with respect to inertial space, body axes"));
  spec.example = R"json({"input": "imu", "blocks": {"attitude": "attitude"}, "gyro_noise": "0.1 deg/sqrt(h)"})json";
  return spec;
}

AttitudeOnly::AttitudeOnly(const Binding& binding)
    : attitude_(binding.port("attitude")),
      fields_{binding.fields("wx", "wy", "wz"), {}},
      q_(declaration_.adds_noise(attitude_, attitude_)),
      memory_(declaration_.keeps<SampleMemory>()),
      algorithm_(attitude::read_choice(binding)),
      density_(binding.parameters().vector("gyro_noise").cwiseAbs2()) {}

Result AttitudeOnly::propagate(const ProcessInput& in, ProcessOutput& out) const {
  SampleMemory remembered = in.memory[memory_];
  Eigen::Vector4d q = in.x[attitude_].as<4>();
  Eigen::Matrix3d Q = Eigen::Matrix3d::Zero();
  for (auto rest = in.step.samples; !rest.empty();) {
    SampleGroup group;
    if (!group.take(rest, algorithm_.samples(), fields_)) return Result::failed(SampleGroup::implausible);
    if (group.count() == 0) continue;
    if (!density_.isZero(0.0)) {
      const Eigen::Matrix3d C = strapdown::dcm_from_quaternion(q);
      Q += C * (group.sum().dt * density_).asDiagonal() * C.transpose();
    }
    q = algorithm_.update()(q, rotation(group, algorithm_, remembered));
  }
  in.memory[memory_] = remembered;
  out.x[attitude_].as<4>() = q;
  if (const BlockView Qd = out.Qd[q_]) Qd.as<3, 3>() = Q;
  return Result::ok();
}

}  // namespace binnacle::attitude_only
