// SPDX-License-Identifier: Apache-2.0
#include "rate_integral.hpp"

namespace binnacle::ship_motion {

ComponentSpec RateIntegral::spec() {
  ComponentSpec spec;
  spec.type = "rate_integral";
  spec.summary = "An angle propagated by a rate gyro, without a model of the ship: dtheta/dt = u - b - n.";
  spec.source = "paper 004, section 2, filter C";
  spec.parameters = {parameter::number("noise", "@angle/sqrt(s)")
                         .at_least(0)
                         .required()
                         .about("root of the power spectral density of the gyro's noise: the sigma of a sample over T "
                                "seconds, times sqrt(T)")};
  spec.ports = {advances("angle", "vector:1:rad").about("angle of the ship: roll, pitch or yaw"),
                reads("drift", "vector:1:rad/s").optional().about("drift b of the gyro")};
  spec.fields = {field::rate("rate", "rad/s").about("rate measured by the gyro, mean over the interval")};
  spec.example =
      R"json({"input": "rate_gyro", "blocks": {"angle": "pitch", "drift": "rate_drift"}, "noise": "0.5 deg/sqrt(s)"})json";
  spec.surroundings = R"json({"blocks": {"pitch": {"type": "vector", "size": 1, "unit": "rad", "sigma": 0.0144},
    "rate_drift": {"type": "vector", "size": 1, "unit": "rad/s", "sigma": 3e-4}}})json";
  return spec;
}

RateIntegral::RateIntegral(const Binding& binding)
    : angle_(binding.port("angle")),
      drift_(binding.port("drift")),
      rate_(binding.field("rate")),
      phi_(declaration_.couples(angle_, drift_)),
      q_(declaration_.adds_noise(angle_, angle_)) {
  const double noise = binding.parameters().number("noise");
  density_ = noise * noise;
}

Result RateIntegral::propagate(const ProcessInput& in, ProcessOutput& out) const {
  double turned = 0;
  const double dt = in.step.dt;
  for (const auto& sample : in.step.samples) turned += sample[rate_] * sample.dt;
  out.x[angle_][0] = in.x[angle_][0] + turned - (drift_.is_bound() ? in.x[drift_][0] * dt : 0.0);
  if (const BlockView phi = out.phi[phi_]) phi.as<1, 1>()(0) = -dt;
  if (const BlockView Q = out.Qd[q_]) Q.as<1, 1>()(0) = density_ * dt;
  return Result::ok();
}

}  // namespace binnacle::ship_motion
