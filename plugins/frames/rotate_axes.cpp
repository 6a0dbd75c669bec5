// SPDX-License-Identifier: Apache-2.0
// IMU samples in other axes.
#include "rotate_axes.hpp"

#include "binnacle/view.hpp"
#include "mounting.hpp"

namespace binnacle::frames {

namespace {

std::vector<FieldSpec> imu_fields(const std::string& axes) {
  std::vector<FieldSpec> fields;
  for (const char* axis : {"x", "y", "z"})
    fields.push_back({std::string("w") + axis, "rad/s", FieldKind::rate, false, false,
                      "angular rate with respect to inertial space, " + axes});
  for (const char* axis : {"x", "y", "z"})
    fields.push_back({std::string("f") + axis, "m/s^2", FieldKind::rate, false, false, "specific force, " + axes});
  return fields;
}

}  // namespace

ComponentSpec RotateAxes::spec() {
  ComponentSpec spec;
  spec.type = "rotate_axes";
  spec.summary = "Inertial samples turned into other axes, as from a sensor's to its vehicle's.";
  spec.parameters = mounting_parameters();
  spec.inputs = {{"input", imu_fields("sensor axes"), false, "the inertial sensor"}};
  spec.example = R"json({"input": "raw_imu", "roll": "170.79 deg", "pitch": "60.5 deg", "yaw": "167.45 deg",
    "flip": "flu_to_frd"})json";
  return spec;
}

RotateAxes::RotateAxes(const Binding& binding) : C_(mounting_rotation(binding.parameters())) {
  ChannelDeclaration channel;
  channel.fields = imu_fields("turned axes");
  channels_.push_back(std::move(channel));
}

void RotateAxes::on(int /*input*/, const SampleView& sample, std::byte* /*memory*/, Emitter& emitter) const {
  SampleSlot& slot = emitter.slot(0);
  slot.t = sample.t;
  slot.t0 = sample.t0;
  vector_at<3>(slot.fields) = C_ * vector_at<3>(sample.fields);
  vector_at<3>(slot.fields + 3) = C_ * vector_at<3>(sample.fields + 3);
  emitter.emit(0);
}

}  // namespace binnacle::frames
