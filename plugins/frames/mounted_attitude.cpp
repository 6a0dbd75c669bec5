// SPDX-License-Identifier: Apache-2.0
// The attitude of other axes fixed to the body.
#include "mounted_attitude.hpp"

#include "binnacle/view.hpp"
#include "mounting.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

ComponentSpec MountedAttitude::spec() {
  ComponentSpec spec;
  spec.type = "mounted_attitude";
  spec.summary =
      "The attitude of other axes fixed to the body, such as those of the vehicle in which the IMU is mounted.";
  spec.source = "paper 001, equations (5) to (7)";
  spec.kind = "attitude";
  spec.parameters = mounting_parameters();
  spec.ports = {reads("attitude", "attitude").about("attitude of the body (IMU) axes"),
                reads("misalignment", "vector:3:rad")
                    .optional()
                    .about("small rotation vector zeta in vehicle axes: C_bv = C_bv0 exp(-[zeta x]), paper 001 (5)")};
  spec.example = R"json({"blocks": {"attitude": "attitude", "misalignment": "misalignment"}, "yaw": "90 deg"})json";
  return spec;
}

MountedAttitude::MountedAttitude(const Binding& binding)
    : attitude_(binding.port("attitude")),
      misalignment_(binding.port("misalignment")),
      q_bv_(strapdown::quaternion_from_dcm(mounting_rotation(binding.parameters()).transpose())) {
  declaration_.yields_like(binding.block("attitude")).reads(attitude_).reads(misalignment_);
}

Result MountedAttitude::evaluate(const DerivedInput& in, DerivedOutput& out) const {
  using namespace strapdown;
  const Eigen::Vector4d nominal = quaternion_product(in.x[attitude_].as<4>(), q_bv_);
  if (const MatrixView J = out.J[attitude_]) J.as<3, 3>().setIdentity();
  if (!misalignment_.is_bound()) {
    out.value.as<4>() = nominal;
    return Result::ok();
  }
  const Eigen::Vector3d zeta = in.x[misalignment_].as<3>();
  out.value.as<4>() = quaternion_product(nominal, quaternion_exp(-zeta));
  if (const MatrixView J = out.J[misalignment_]) J.as<3, 3>() = -dcm_from_quaternion(nominal) * left_jacobian(-zeta);
  return Result::ok();
}

}  // namespace binnacle::frames
