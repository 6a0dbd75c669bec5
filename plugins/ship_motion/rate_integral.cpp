// SPDX-License-Identifier: Apache-2.0
#include "rate_integral.hpp"

namespace binnacle::ship_motion {

namespace {
enum Port { angle, drift };
}  // namespace

ComponentSpec RateIntegral::spec() {
  ComponentSpec spec;
  spec.type = "rate_integral";
  spec.summary = "An angle that a rate gyro moves, without a model of the ship: dtheta/dt = u - b - n.";
  spec.source = "paper 004, section 2, filter C";
  spec.parameters = {parameter::number("noise", "@angle/sqrt(s)")
                         .at_least(0)
                         .required()
                         .about("root of the power spectral density of the gyro's noise: per sample of T seconds, its "
                                "sigma times sqrt(T)")};
  spec.ports = {advances("angle", "vector:1:rad", "roll, pitch or yaw"),
                may_read("drift", "vector:1:rad/s", "b, the gyro's drift")};
  FieldSpec rate;
  rate.name = "rate";
  rate.unit = "rad/s";
  rate.kind = FieldKind::rate;
  rate.text = "the gyro's reading, mean over the interval";
  spec.fields = {rate};
  spec.example =
      R"json({"input": "rate_gyro", "blocks": {"angle": "pitch", "drift": "rate_drift"}, "noise": "0.5 deg/sqrt(s)"})json";
  spec.surroundings = R"json({"blocks": {"pitch": {"type": "vector", "size": 1, "unit": "rad", "sigma": 0.0144},
    "rate_drift": {"type": "vector", "size": 1, "unit": "rad/s", "sigma": 3e-4}}})json";
  return spec;
}

RateIntegral::RateIntegral(const Binding& binding) : has_drift_(binding.is_bound("drift")) {
  const double noise = binding.parameters().number("noise");
  density_ = noise * noise;
  if (has_drift_) declaration_.transition = {{angle, drift, Structure::dense}};
  declaration_.noise = {{angle, angle, Structure::dense}};
}

Result RateIntegral::propagate(const Step& step, const double* const* x, std::byte* /*memory*/,
                               const legacy::ProcessOutput& out) const {
  double turned = 0;
  for (const auto& sample : step.samples) turned += sample.fields[0] * sample.dt;
  out.x_plus[angle][0] = x[angle][0] + turned - (has_drift_ ? x[drift][0] * step.dt : 0.0);
  if (has_drift_) out.transition[0][0] = -step.dt;
  out.noise[0][0] = density_ * step.dt;
  return Result::ok();
}

}  // namespace binnacle::ship_motion
