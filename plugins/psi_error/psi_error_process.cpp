// SPDX-License-Identifier: Apache-2.0
// Strapdown navigation in north-east-down axes with the psi-angle error model.
#include "psi_error_process.hpp"

#include "psi_model.hpp"

namespace binnacle::psi_error {

namespace {

strapdown::TransitionBlocks in_psi(const inertial::StepTaken& step, bool with_position) {
  return psi_transition(step.advanced.mid, step.has_sensor_errors ? &step.input : nullptr, step.order, with_position);
}

strapdown::TransitionBlocks in_computed_axes(const inertial::StepTaken& step) {
  return in_psi(step, step.has_position_errors);
}

strapdown::TransitionBlocks in_true_axes(const inertial::StepTaken& step) {
  return translated(in_psi(step, true), Translation(step.before), Translation(step.advanced.nav),
                    step.has_sensor_errors);
}

inertial::ErrorModel model(const Parameters& parameters) {
  if (parameters.text("axes") == "computed") return {&in_computed_axes, true};
  return {&in_true_axes, false};
}

}  // namespace

ComponentSpec PsiErrorProcess::spec() {
  ComponentSpec spec;
  spec.type = "psi_error";
  spec.summary = "Strapdown inertial navigation in north-east-down axes with the psi-angle error model.";
  spec.source =
      "paper 000, equation (1); Goshen-Meskin, Bar-Itzhack, A Unified Approach to Inertial Navigation System "
      "Error Modeling, AIAA-90-3367-CP, 1990";
  describe(spec);
  spec.parameters.push_back(parameter::choice("axes", {"true", "computed"})
                                .defaults("\"true\"")
                                .about("axes of the errors: those of the blocks, or those at the computed position "
                                       "(only with a frozen position)"));
  spec.example = R"json({"input": "imu", "blocks": {"position": "position", "velocity": "velocity",
    "attitude": "attitude", "gyro_bias": "gyro_bias", "accel_bias": "accel_bias"},
    "gyro_noise": "0.05 deg/sqrt(h)", "accel_noise": "450 ug/sqrt(Hz)"})json";
  return spec;
}

PsiErrorProcess::PsiErrorProcess(const Binding& binding) : InertialProcess(binding, model(binding.parameters())) {}

}  // namespace binnacle::psi_error
