// SPDX-License-Identifier: Apache-2.0
// The attitude of other axes fixed to the body.
#include "mounted_attitude.hpp"

#include "binnacle/view.hpp"
#include "mounting.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

namespace {

enum Port { attitude_port, misalignment_port };

}  // namespace

ComponentSpec MountedAttitude::spec() {
  ComponentSpec spec;
  spec.type = "mounted_attitude";
  spec.summary = "The attitude of other axes fixed to the body, such as the vehicle that the IMU is mounted in.";
  spec.source = "paper 001, equations (5) to (7)";
  spec.kind = "attitude";
  spec.parameters = mounting_parameters();
  spec.ports = {reads("attitude", "attitude", "of the body (IMU) axes"),
                may_read("misalignment", "vector:3:rad",
                         "small rotation vector zeta in vehicle axes: C_bv = C_bv0 exp(-[zeta x]), paper 001 (5)")};
  spec.example = R"json({"blocks": {"attitude": "attitude", "misalignment": "misalignment"}, "yaw": "90 deg"})json";
  return spec;
}

MountedAttitude::MountedAttitude(const Binding& binding)
    : q_bv_(strapdown::quaternion_from_dcm(mounting_rotation(binding.parameters()).transpose())),
      has_misalignment_(binding.is_bound("misalignment")) {
  const PortBinding& attitude = binding.block("attitude");
  declaration_.kind = attitude.kind;
  declaration_.stored_size = attitude.stored_size;
  declaration_.error = attitude.components;
  declaration_.read_ports = {attitude_port};
  if (has_misalignment_) declaration_.read_ports.push_back(misalignment_port);
}

Result MountedAttitude::evaluate(const double* const* x, const legacy::Context& /*context*/, double* value,
                                 const MatrixView* J) const {
  using namespace strapdown;
  const Eigen::Vector4d nominal = quaternion_product(vector_at<4>(x[attitude_port]), q_bv_);
  if (J) J[0].as<3, 3>().setIdentity();
  if (!has_misalignment_) {
    vector_at<4>(value) = nominal;
    return Result::ok();
  }
  const Eigen::Vector3d zeta = vector_at<3>(x[misalignment_port]);
  vector_at<4>(value) = quaternion_product(nominal, quaternion_exp(-zeta));
  if (J) J[1].as<3, 3>() = -dcm_from_quaternion(nominal) * left_jacobian(-zeta);
  return Result::ok();
}

}  // namespace binnacle::frames
