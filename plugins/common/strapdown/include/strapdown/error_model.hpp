// SPDX-License-Identifier: Apache-2.0
// The tilt (phi) error model of the NED mechanization: transition and noise blocks over one step.
#pragma once

#include <Eigen/Core>

#include "strapdown/mechanization.hpp"

namespace binnacle::strapdown {

// truth = estimate ⊞ δ, δ = (p, v, phi):
//   p    north, east, down, m: position_plus           v    m/s, additive, NED
//   phi  rad, NED: q_true = exp(phi) ⊗ q_hat           biases and scale factors additive.
// With ω_ie, ω_en, ω_in = ω_ie + ω_en, f = C f_b in navigation axes and δω_en = W δv + …:
//   ṗ   = F_pp p + v                       F_pp: rates of change of the chart of position_plus, see error_model.cpp
//   v̇   = −[f×] phi − [(2ω_ie + ω_en)×] v + [v×](2δω_ie + δω_en) + δg + C δf
//   phi̇ = −[ω_in×] phi − (δω_ie + δω_en) + C δω
// Paper 003, equations (1)–(3), has δ = computed − true and C_hat = (I − [phi×]) C: attitude keeps its sign,
// position, velocity and sensor errors flip, so here F_vphi and F_phiv, F_phip have the other sign.

/// Errors of the sensors, per body axis: measured = (1 + scale) true + bias.
struct SensorErrors {
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();    ///< rad/s
  Eigen::Vector3d gyro_scale = Eigen::Vector3d::Zero();   ///< 1
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();   ///< m/s²
  Eigen::Vector3d accel_scale = Eigen::Vector3d::Zero();  ///< 1
};

/// true = (measured − bias) / (1 + scale), on increments: (Δ − bias dt) / (1 + scale). The neighbour that the
/// coning term uses (Previous) should be corrected by the same estimates; an older correction costs |ω| dt²/12 of
/// the difference, once.
Increment correct(const Increment& measured, const SensorErrors& errors);

/// ∂(true increment)/∂(error), each the diagonal of a 3×3 in body axes:
///   ∂Δθ/∂b_g = −dt/(1+s_g)   ∂Δθ/∂s_g = −Δθ/(1+s_g)   ∂Δv/∂b_a = −dt/(1+s_a)   ∂Δv/∂s_a = −Δv/(1+s_a)
/// with Δ the corrected increments.
struct InputSensitivity {
  Eigen::Vector3d gyro_bias;    ///< rad / (rad/s)
  Eigen::Vector3d gyro_scale;   ///< rad
  Eigen::Vector3d accel_bias;   ///< (m/s) / (m/s²)
  Eigen::Vector3d accel_scale;  ///< m/s
};
InputSensitivity input_sensitivity(const Increment& corrected, const SensorErrors& errors = {});

/// Φ over one step, by 3×3 blocks: row block _ column block; bg, sg, ba, sa are gyro bias and scale factor,
/// accelerometer bias and scale factor. Blocks that are not named (p_bg, p_sg) are O(dt³) and taken as zero.
struct TransitionBlocks {
  Eigen::Matrix3d p_p, p_v, p_phi, p_ba, p_sa;
  Eigen::Matrix3d v_p, v_v, v_phi, v_bg, v_sg, v_ba, v_sa;
  Eigen::Matrix3d phi_p, phi_v, phi_phi, phi_bg, phi_sg, phi_ba, phi_sa;
};

/// first:  I + F dt at the middle of the step, local error O(dt²); p_phi, p_ba, p_sa, v_bg, v_sg, phi_ba, phi_sa are
///         zero.
/// second: I + F dt + ½ F² dt², local error O(dt³); no named block is zero.
enum class Order { first, second };

TransitionBlocks transition(const Midpoint& mid, const InputSensitivity& input, Order order);

/// Power spectral densities of the white noise of the sensors, per body axis (two-sided: ARW², VRW²).
struct NoiseDensity {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< rad²/s
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< (m/s)²/s
  /// s²: mean square of the time for which rates of density G turned f; adds turned_squared K G Kᵀ to A below.
  double turned_squared = 0.0;
};

/// Q over one step: the upper triangle, by blocks; the diagonal ones are symmetric.
struct NoiseBlocks {
  Eigen::Matrix3d p_p, p_v, p_phi;
  Eigen::Matrix3d v_v, v_phi;
  Eigen::Matrix3d phi_phi;
};

/// With G = C S_g Cᵀ, A = C S_a Cᵀ, K = [f×] and B = K G Kᵀ, all at the middle of the step, h = dt:
///   phi_phi = G h         v_phi = −K G h²/2      p_phi = −K G h³/6
///   v_v = A h + B h³/3    p_v = A h²/2 + B h⁴/8  p_p = A h³/3 + B h⁵/20
/// This is exactly the covariance of ṗ = v, v̇ = −K phi + w_a, phi̇ = w_g, hence positive semidefinite; every block is
/// right in its leading power of h.
/// Without position p_p, p_v and p_phi are left unset.
NoiseBlocks process_noise(const Midpoint& mid, const NoiseDensity& density, bool with_position = true);

}  // namespace binnacle::strapdown
