// SPDX-License-Identifier: Apache-2.0
// IMU samples in other axes.
#include "rotate_axes.hpp"

#include "binnacle/view.hpp"
#include "mounting.hpp"
#include "strapdown/rotation.hpp"

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

std::vector<FieldSpec> truth_fields(const std::string& axes) {
  std::vector<FieldSpec> fields;
  for (const char* name : {"roll", "pitch", "yaw"})
    fields.push_back({name, "rad", FieldKind::level, false, false, "true attitude, " + axes});
  for (const char* name : {"mount_x", "mount_y", "mount_z"})
    fields.push_back({name, "rad", FieldKind::level, true, false, "true misalignment in the vehicle, " + axes});
  return fields;
}

}  // namespace

ComponentSpec RotateAxes::spec() {
  ComponentSpec spec;
  spec.type = "rotate_axes";
  spec.summary = "Inertial samples turned into other axes, as from a sensor's to its vehicle's.";
  spec.parameters = mounting_parameters();
  spec.inputs = {{"imu", imu_fields("sensor axes"), false, "the inertial sensor"},
                 {"truth", truth_fields("sensor axes"), true,
                  "of a simulation, to be told of the turned axes as well"}};
  spec.example = R"json({"input": "raw_imu", "roll": "170.79 deg", "pitch": "60.5 deg", "yaw": "167.45 deg",
    "flip": "flu_to_frd"})json";
  return spec;
}

RotateAxes::RotateAxes(const Binding& binding) : C_(mounting_rotation(binding.parameters())) {
  ChannelDeclaration imu, truth;
  imu.fields = imu_fields("turned axes");
  truth.name = "truth";
  truth.fields = truth_fields("turned axes");
  channels_ = {std::move(imu), std::move(truth)};
}

void RotateAxes::on(int input, const SampleView& sample, std::byte* /*memory*/, Emitter& emitter) const {
  if (input == 1) return on_truth(sample, emitter);
  SampleSlot& slot = emitter.slot(0);
  slot.t = sample.t;
  slot.t0 = sample.t0;
  vector_at<3>(slot.fields) = C_ * vector_at<3>(sample.fields);
  vector_at<3>(slot.fields + 3) = C_ * vector_at<3>(sample.fields + 3);
  emitter.emit(0);
}

void RotateAxes::on_truth(const SampleView& sample, Emitter& emitter) const {
  using namespace strapdown;
  const Eigen::Vector4d q_turn = quaternion_from_dcm(C_);
  const Eigen::Vector4d q_nb = quaternion_from_euler(vector_at<3>(sample.fields));
  SampleSlot& slot = emitter.slot(1);
  slot.t = sample.t;
  vector_at<3>(slot.fields) = euler_from_quaternion(quaternion_product(q_nb, quaternion_conjugate(q_turn)));
  const Eigen::Vector3d zeta = vector_at<3>(sample.fields + 3);
  if (zeta.allFinite())
    vector_at<3>(slot.fields + 3) = -quaternion_log(quaternion_product(q_turn, quaternion_exp(-zeta)));
  emitter.emit(1);
}

}  // namespace binnacle::frames
