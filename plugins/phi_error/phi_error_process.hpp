// SPDX-License-Identifier: Apache-2.0
// Strapdown navigation in north-east-down axes: mechanization, tilt error model, sensor errors.
#pragma once

#include <array>
#include <cstddef>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"
#include "strapdown/error_model.hpp"

namespace binnacle::phi_error {

/// The error model of one sample, or of a group of them.
struct Linearized {
  strapdown::TransitionBlocks transition;
  strapdown::NoiseBlocks noise;
};

/// Advances position, velocity and attitude by an inertial sensor's increments (strapdown/mechanization.hpp), after
/// taking off the bias and scale factor blocks that are plugged in (strapdown/error_model.hpp: signs and equations).
///
/// Several samples in one step are folded: Φ = Φ_n … Φ_1, Q = Φ_n Q Φ_nᵀ + Q_n. Blocks of such a product which the
/// declaration lacks are of the order that is neglected anyway.
class PhiErrorProcess final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit PhiErrorProcess(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const ProcessOutput& out) const override;

 private:
  /// Which block of the error model stands at a place of the declaration.
  using TransitionBlock = Eigen::Matrix3d strapdown::TransitionBlocks::*;
  using NoiseBlock = Eigen::Matrix3d strapdown::NoiseBlocks::*;

  void declare_transition(const Binding& binding);
  void declare_noise();
  void write(const Linearized& linearized, const ProcessOutput& out) const;
  void write_identity(const ProcessOutput& out) const;

  ProcessDeclaration declaration_;
  std::array<TransitionBlock, 19> transition_{};  // as many as declaration_.transition
  std::array<NoiseBlock, 6> noise_{};             // as many as declaration_.noise
  strapdown::Order order_;
  strapdown::NoiseDensity density_;
};

}  // namespace binnacle::phi_error
