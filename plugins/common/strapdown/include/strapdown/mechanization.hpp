// SPDX-License-Identifier: Apache-2.0
// Strapdown mechanization in north-east-down axes, from the increments of an inertial sensor.
#pragma once

#include <span>

#include <Eigen/Core>

#include "attitude/algorithm.hpp"

namespace binnacle::strapdown {

struct Navigation {
  Eigen::Vector3d lla = Eigen::Vector3d::Zero();    ///< latitude rad, longitude rad, height m
  Eigen::Vector3d v_n = Eigen::Vector3d::Zero();    ///< velocity over ground, NED, m/s
  Eigen::Vector4d q_nb = Eigen::Vector4d::UnitX();  ///< body to navigation, (w, x, y, z)
};

/// Integrals of angular rate (omega_ib_b) and specific force (f_b) over dt in body axes, corrected by the caller.
/// A sample cut in two at a measurement's time becomes two fragments of proportional increments: each then states the
/// length of the sample it was cut from and how far into that sample it begins. A whole sample leaves both zero.
struct Increment {
  double dt = 0.0;                                   ///< s, > 0
  Eigen::Vector3d dtheta = Eigen::Vector3d::Zero();  ///< rad
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();      ///< m/s
  double sample_dt = 0.0;                            ///< s, length of the source sample; 0: this is the sample
  double sample_offset = 0.0;                        ///< s, from the source sample's start; > 0 continues it
};

/// Mean rates of one whole sample; dt = 0 means none.
struct MeanRates {
  double dt = 0.0;                                  ///< s
  Eigen::Vector3d omega = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d f = Eigen::Vector3d::Zero();      ///< m/s²
};

/// What the mechanization remembers of the samples behind it: the one begun last (perhaps still in fragments) and the
/// one before that, which serves as the neighbour while `last` is unfinished. A default one means nothing is known.
/// After a gap in the data start again from Previous{}.
struct Previous {
  MeanRates last;
  MeanRates before;
};

/// The memory after `increment`.
Previous remember(const Previous& previous, const Increment& increment);

/// What was evaluated at the middle of the step: enough to linearize it (error_model.hpp) without a second pass.
struct Midpoint {
  double dt;  ///< s
  double sin_lat, cos_lat, tan_lat;
  double r_m, r_t;             ///< m, R_m + h and R_t + h
  double d_r_m, d_r_t;         ///< m/rad, by latitude
  double g, g_lat, g_height;   ///< gravity along down and its partials (earth.hpp)
  Eigen::Vector3d v_n;         ///< m/s, mean velocity
  Eigen::Vector3d f_n;         ///< m/s², mean specific force in navigation axes
  Eigen::Vector3d omega_ie_n;  ///< rad/s
  Eigen::Vector3d omega_en_n;  ///< rad/s
  Eigen::Matrix3d C_nb;
};

struct Step {
  Navigation nav;
  Midpoint mid;
};

/// The body's rotation vector over a step, and the first and second integral of specific force, in body axes at its start.
struct BodyMotion {
  double dt;                 ///< s
  Eigen::Vector3d rotation;  ///< rad
  Eigen::Vector3d velocity;  ///< m/s, u = ∫ C f dt
  Eigen::Vector3d position;  ///< m, S = ∫ (h − t) C f dt
};

/// Over one increment and its neighbour (dt = 0: none), as described below.
BodyMotion body_motion(const Increment& increment, const MeanRates& neighbour, const attitude::Algorithm& algorithm);

/// Over 2 to 4 whole increments. With the algorithm's k_ij, and s_i, m_ij of polynomial rates (attitude/interval_weights.hpp):
///     rotation  Σθ + Σ k_ij θ_i × θ_j
///     velocity  what Σθ, Σ Δv give at constant rates, + Σ k_ij (θ_i × Δv_j + Δv_i × θ_j)
///     position  h Σ s_i Δv_i + h Σ m_ij θ_i × Δv_j + what constant rates give of third order
/// For rates that change as polynomials of degree N − 1, what is left out is of third order in θ and of first order in their
/// change: as with one sample, terms like θ × (θ₁ × θ₂)/12.
BodyMotion body_motion(std::span<const Increment> increments, const attitude::Algorithm& algorithm);

/// One step of navigation over what the body did; `update` carries the attitude.
Step step(const Navigation& nav, const BodyMotion& body, const attitude::Update& update);

/// One step over one increment.
///
/// Angular rate and specific force are taken to be linear in time, the line drawn through the mean rates of this sample
/// and of its neighbour (Previous), whatever their lengths H and h0, so that their centres lie τ = (H + h0)/2 apart:
///     coning    δφ = (h H²/12) (ω0 × ω1)/τ             [= h²/(6 h0 (h+h0)) Δθ0 × Δθ1; 1/12 Δθ0 × Δθ1 if h = h0]
///     sculling  δu = (h H²/12) (ω0 × f1 + f0 × ω1)/τ
///     scrolling δS = −(h H²/12) (f1 − f0)/τ            [in S = ∫(h−t) C f dt]
/// on top of what is exact for constant rates. h is the length of the increment; for a whole sample h = H. Of a sample
/// cut into fragments each takes its share of the whole sample's terms, and all of them use the neighbour before the
/// sample: so the cut changes nothing but O(h⁴), and what follows a short fragment sees the centre of the sample, not
/// the fragment's. Without a neighbour (previous.last.dt = 0) the rates are constant over the sample.
///
/// The navigation frame turns during the step: velocity increments by −ω_in × ∫ t C f dt, attitude by −∫ω_in dt.
/// Coriolis and transport rate come from the step's mean velocity, gravity and radii from its middle.
///
/// Order: local error O(h⁴), global error O(h³) in position, velocity and attitude for smooth motion, from the second
/// derivatives of the rates. Without neighbours it is O(h²) (no coning). Terms kept out although of second order are
/// (ω_in h)² f/6 in acceleration (1e-11 m/s² at 100 Hz and 300 m/s), h² v̇²/(12 R) likewise (3e-11 m/s² for 5 m/s²) and
/// h² v̇ v/(12 R) in velocity (2e-9 m/s).
/// NED axes are singular at the poles.
Step step(const Navigation& nav, const Increment& increment, const Previous& previous);

/// step(...).nav.
Navigation advance(const Navigation& nav, const Increment& increment, const Previous& previous = {});

/// Several increments one after another, of whatever lengths; `previous` is what preceded the first. It has no default:
/// with two arguments argument-dependent lookup would find std::advance.
Navigation advance(const Navigation& nav, std::span<const Increment> increments, Previous previous);

}  // namespace binnacle::strapdown
