// SPDX-License-Identifier: Apache-2.0
// Strapdown navigation in north-east-down axes with the psi-angle error model.
#pragma once

#include "binnacle/spec.hpp"
#include "inertial/inertial_process.hpp"

namespace binnacle::psi_error {

/// The inertial process with the psi-angle error model (psi_model.hpp: equations, signs, and what `axes` means).
class PsiErrorProcess final : public inertial::InertialProcess {
 public:
  static ComponentSpec spec();
  explicit PsiErrorProcess(const Binding& binding);
};

}  // namespace binnacle::psi_error
