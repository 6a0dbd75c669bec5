// SPDX-License-Identifier: Apache-2.0
// Strapdown navigation in north-east-down axes: mechanization, tilt error model, sensor errors.
#pragma once

#include "binnacle/spec.hpp"
#include "inertial/inertial_process.hpp"

namespace binnacle::phi_error {

/// The inertial process with the tilt error model (strapdown/error_model.hpp: equations and signs).
class PhiErrorProcess final : public inertial::InertialProcess {
 public:
  static ComponentSpec spec();
  explicit PhiErrorProcess(const Binding& binding);
};

}  // namespace binnacle::phi_error
