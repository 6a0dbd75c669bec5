// SPDX-License-Identifier: Apache-2.0
// The psi-angle error model of the NED mechanization, and what it is in the errors of the standard blocks.
#pragma once

#include <Eigen/Core>

#include "strapdown/error_model.hpp"
#include "strapdown/mechanization.hpp"

namespace binnacle::psi_error {

// Three sets of axes: those at the true position (t), those at the computed position (c), and those that the computed
// attitude leads to (p). φ turns t into p, δθ turns t into c, ψ turns c into p: φ = ψ + δθ.
//
// Paper 000 (1) has δ = computed − true and, as its (5) corrected says, Ĉ = (I − [ψ×]) C. Translated here, once, to
// truth = estimate ⊞ δ: ψ keeps its sign; position, velocity and sensor errors flip, so F ψ becomes −[f×] ψ and
// + δf, + δω become − C b. With p (north, east, down, m), u = v_true in axes c − v̂, w = 2ω_ie + ω_en:
//
//   ṗ = −[ω_en×] p + u                       G p = δγ e_D + (W p) × γ e_D = (−γ N/r_m, −γ E/r_t, γ_L N/r_m − γ_h D)
//   u̇ = G p − [w×] u − [f×] ψ − C δf
//   ψ̇ = −[(ω_ie + ω_en)×] ψ − C δω
//
// Nothing is left out: axes c turn with what is computed, so ω_ie and ω_en have no errors there. (Goshen-Meskin and
// Bar-Itzhack 1990. The paper prints the last two without G p.)

/// Φ of one step in p, u, ψ; `phi` in the names of the blocks stands for ψ. first: I + F dt. second: + ½F²dt².
/// input: null where no sensor error is plugged in. The blocks of its columns are then unset, and without position those of
/// its rows and columns.
strapdown::TransitionBlocks psi_transition(const strapdown::Midpoint& mid, const strapdown::InputSensitivity* input,
                                           strapdown::Order order, bool with_position = true);

/// From the errors of the standard blocks, p, v and φ against axes t, to those of the ψ model, at one instant. There
/// −δθ = W p with W = ∂ω_en/∂v, so
///   ψ = φ + W p        u = v + (W p) × v̂ = v − [v̂×] W p
struct Translation {
  Eigen::Matrix3d W;         ///< rad/m
  Eigen::Matrix3d minus_vW;  ///< −[v̂×] W, 1/s

  explicit Translation(const strapdown::Navigation& nav);
};

/// T(after)⁻¹ Φ T(before): Φ in the errors that the standard blocks declare. Columns of sensor errors where there are any.
strapdown::TransitionBlocks translated(const strapdown::TransitionBlocks& psi, const Translation& before,
                                       const Translation& after, bool has_sensor_errors);

}  // namespace binnacle::psi_error
