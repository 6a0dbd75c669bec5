// SPDX-License-Identifier: Apache-2.0
// IMU samples in other axes.
#include "rotate_axes.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "mounting.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

namespace {

using Triad = std::array<FieldSpec, 3>;

Triad rates(const std::string& axes) {
  const auto rate = [&](const char* name) {
    return field::rate(name, "rad/s").about("angular rate with respect to inertial space, " + axes);
  };
  return {rate("wx"), rate("wy"), rate("wz")};
}

Triad forces(const std::string& axes) {
  const auto force = [&](const char* name) { return field::rate(name, "m/s^2").about("specific force, " + axes); };
  return {force("fx"), force("fy"), force("fz")};
}

Triad angles(const std::string& axes) {
  const auto angle = [&](const char* name) { return field::level(name, "rad").about("true attitude, " + axes); };
  return {angle("roll"), angle("pitch"), angle("yaw")};
}

Triad misalignments(const std::string& axes) {
  const auto angle = [&](const char* name) {
    return field::level(name, "rad").optional().about("true misalignment in the vehicle, " + axes);
  };
  return {angle("mount_x"), angle("mount_y"), angle("mount_z")};
}

std::vector<FieldSpec> joined(const Triad& first, const Triad& second) {
  std::vector<FieldSpec> all(first.begin(), first.end());
  all.insert(all.end(), second.begin(), second.end());
  return all;
}

}  // namespace

ComponentSpec RotateAxes::spec() {
  ComponentSpec spec;
  spec.type = "rotate_axes";
  spec.summary = "Inertial samples rotated into other axes, for example from the sensor's to the vehicle's axes.";
  spec.parameters = mounting_parameters();
  const char* const axes = "sensor axes";
  spec.inputs = {input("imu", joined(rates(axes), forces(axes))).about("the inertial sensor"),
                 input("truth", joined(angles(axes), misalignments(axes)))
                     .optional()
                     .about("truth of a simulation, which is rotated in the same way")};
  spec.example = R"json({"input": "raw_imu", "roll": "170.79 deg", "pitch": "60.5 deg", "yaw": "167.45 deg",
    "flip": "flu_to_frd"})json";
  return spec;
}

RotateAxes::RotateAxes(const Binding& binding)
    : C_(mounting_rotation(binding.parameters())), imu_(binding.input("imu")) {
  const Input true_axes = binding.input("truth");
  w_ = binding.fields(imu_, "wx", "wy", "wz");
  f_ = binding.fields(imu_, "fx", "fy", "fz");
  attitude_ = binding.fields(true_axes, "roll", "pitch", "yaw");
  mounting_ = binding.fields(true_axes, "mount_x", "mount_y", "mount_z");

  const char* const axes = "turned axes";
  ChannelDeclaration imu, truth("truth");
  turned_w_ = imu.carries(rates(axes));
  turned_f_ = imu.carries(forces(axes));
  turned_attitude_ = truth.carries(angles(axes));
  turned_mounting_ = truth.carries(misalignments(axes));
  turned_imu_ = declaration_.emits(std::move(imu));
  turned_truth_ = declaration_.emits(std::move(truth));
}

void RotateAxes::on(const TransformInput& in, Emitter& emitter) const {
  if (in.from != imu_) return on_truth(in.sample, emitter);
  SampleWriter& out = emitter.on(turned_imu_);
  out.t = in.sample.t;
  out.t0 = in.sample.t0;
  out[turned_w_] = C_ * in.sample[w_];
  out[turned_f_] = C_ * in.sample[f_];
  emitter.emit(turned_imu_);
}

void RotateAxes::on_truth(const SampleView& sample, Emitter& emitter) const {
  using namespace strapdown;
  const Eigen::Vector4d q_turn = quaternion_from_dcm(C_);
  const Eigen::Vector4d q_nb = quaternion_from_euler(sample[attitude_]);
  SampleWriter& out = emitter.on(turned_truth_);
  out.t = sample.t;
  out[turned_attitude_] = euler_from_quaternion(quaternion_product(q_nb, quaternion_conjugate(q_turn)));
  const Eigen::Vector3d zeta = sample[mounting_];
  if (zeta.allFinite()) out[turned_mounting_] = -quaternion_log(quaternion_product(q_turn, quaternion_exp(-zeta)));
  emitter.emit(turned_truth_);
}

}  // namespace binnacle::frames
