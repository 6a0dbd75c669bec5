// SPDX-License-Identifier: Apache-2.0
// Strapdown navigation in north-east-down axes.
#include "phi_error_process.hpp"

namespace binnacle::phi_error {

namespace {

strapdown::TransitionBlocks transition(const inertial::StepTaken& at) {
  return strapdown::transition(at.advanced.mid, at.input, at.order);
}

}  // namespace

ComponentSpec PhiErrorProcess::spec() {
  ComponentSpec spec;
  spec.type = "phi_error";
  spec.summary = "Strapdown inertial navigation in north-east-down axes with the tilt (phi) error model.";
  spec.source = "papers 001 and 003, equations (1) to (3), with exact gravity and transport terms";
  describe(spec);
  spec.example = R"json({"input": "imu", "blocks": {"position": "position", "velocity": "velocity",
    "attitude": "attitude", "gyro_bias": "gyro_bias", "accel_bias": "accel_bias"},
    "gyro_noise": "0.3 deg/sqrt(h)", "accel_noise": "100 ug/sqrt(Hz)"})json";
  return spec;
}

PhiErrorProcess::PhiErrorProcess(const Binding& binding) : InertialProcess(binding, {&transition}) {}

}  // namespace binnacle::phi_error
