// SPDX-License-Identifier: Apache-2.0
// The psi-angle error model of the NED mechanization.
#include "psi_model.hpp"

#include <cmath>

#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::psi_error {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using strapdown::skew;
using strapdown::TransitionBlocks;

/// G dt: what of it is not zero.
struct GravityGradient {
  double north, east, down_north, down;

  Matrix3d matrix() const {
    Matrix3d G;
    G << north, 0, 0, 0, east, 0, down_north, 0, down;
    return G;
  }
  /// G [a×] and [a×] G.
  Matrix3d times_cross(const Vector3d& a) const {
    Matrix3d m;
    m << 0, north * -a[2], north * a[1], east * a[2], 0, east * -a[0], down * -a[1],
        down_north * -a[2] + down * a[0], down_north * a[1];
    return m;
  }
  Matrix3d crossed(const Vector3d& a) const {
    Matrix3d m;
    m << a[1] * down_north, -a[2] * east, a[1] * down, a[2] * north + -a[0] * down_north, 0, -a[0] * down,
        -a[1] * north, a[0] * east, 0;
    return m;
  }
};

/// [a×][b×] = b aᵀ − (a·b) I
Matrix3d cross_cross(const Vector3d& a, const Vector3d& b) {
  const double x = a[0] * b[0], y = a[1] * b[1], z = a[2] * b[2];
  Matrix3d m;
  m << -(y + z), a[1] * b[0], a[2] * b[0], a[0] * b[1], -(x + z), a[2] * b[1], a[0] * b[2], a[1] * b[2], -(x + y);
  return m;
}

/// F dt of ẋ = F x in (p, u, ψ), by vectors a of [a×] where a block is that; its block (p, u) is I dt, (p, ψ), (ψ, p)
/// and (ψ, u) are zero.
struct Generator {
  double dt;
  Vector3d p_p;
  GravityGradient u_p;
  Vector3d u_u, u_psi, psi_psi;
};

Generator generator(const strapdown::Midpoint& mid) {
  const double dt = mid.dt;
  return {dt,
          -dt * mid.omega_en_n,
          {dt * (-mid.g / mid.r_m), dt * (-mid.g / mid.r_t), dt * (mid.g_lat / mid.r_m), dt * -mid.g_height},
          -dt * (2.0 * mid.omega_ie_n + mid.omega_en_n),
          -dt * mid.f_n,
          -dt * (mid.omega_ie_n + mid.omega_en_n)};
}

void clear_sensor_errors(TransitionBlocks& t) {
  for (Matrix3d* block :
       {&t.p_ba, &t.p_sa, &t.v_bg, &t.v_sg, &t.v_ba, &t.v_sa, &t.phi_bg, &t.phi_sg, &t.phi_ba, &t.phi_sa})
    block->setZero();
}

void add_sensor_errors(TransitionBlocks& t, const Matrix3d& C_nb, const strapdown::InputSensitivity& input) {
  const Matrix3d gyro_bias = C_nb * input.gyro_bias.asDiagonal(), gyro_scale = C_nb * input.gyro_scale.asDiagonal();
  const Matrix3d accel_bias = C_nb * input.accel_bias.asDiagonal();
  const Matrix3d accel_scale = C_nb * input.accel_scale.asDiagonal();
  t.v_ba = accel_bias, t.v_sa = accel_scale;
  t.phi_bg = gyro_bias, t.phi_sg = gyro_scale;
}

/// An input error enters through C and is then carried for half a step: (I + ½ F dt) C.
void carry_sensor_errors(TransitionBlocks& t, const Generator& a) {
  const Matrix3d u_u = skew(a.u_u), u_psi = skew(a.u_psi), psi_psi = skew(a.psi_psi);
  t.p_ba = 0.5 * a.dt * t.v_ba, t.p_sa = 0.5 * a.dt * t.v_sa;
  t.v_ba += 0.5 * u_u * t.v_ba.eval(), t.v_sa += 0.5 * u_u * t.v_sa.eval();
  t.v_bg = 0.5 * u_psi * t.phi_bg, t.v_sg = 0.5 * u_psi * t.phi_sg;
  t.phi_bg += 0.5 * psi_psi * t.phi_bg.eval(), t.phi_sg += 0.5 * psi_psi * t.phi_sg.eval();
}

}  // namespace

TransitionBlocks psi_transition(const strapdown::Midpoint& mid, const strapdown::InputSensitivity* input,
                                strapdown::Order order) {
  const Generator a = generator(mid);
  const Matrix3d I = Matrix3d::Identity(), p_p = skew(a.p_p), u_p = a.u_p.matrix(), u_u = skew(a.u_u);
  const Matrix3d u_psi = skew(a.u_psi);
  TransitionBlocks t;
  t.phi_p = t.phi_v = t.p_phi = Matrix3d::Zero();
  t.p_p = I + p_p, t.p_v = a.dt * I;
  t.v_p = u_p, t.v_v = I + u_u, t.v_phi = u_psi;
  t.phi_phi = I + skew(a.psi_psi);
  clear_sensor_errors(t);
  if (input) add_sensor_errors(t, mid.C_nb, *input);
  if (order == strapdown::Order::first) return t;

  t.p_p += 0.5 * (cross_cross(a.p_p, a.p_p) + a.dt * u_p);
  t.p_v += 0.5 * a.dt * (p_p + u_u);
  t.p_phi = 0.5 * a.dt * u_psi;
  t.v_p += 0.5 * (a.u_p.times_cross(a.p_p) + a.u_p.crossed(a.u_u));
  t.v_v += 0.5 * (a.dt * u_p + cross_cross(a.u_u, a.u_u));
  t.v_phi += 0.5 * (cross_cross(a.u_u, a.u_psi) + cross_cross(a.u_psi, a.psi_psi));
  t.phi_phi += 0.5 * cross_cross(a.psi_psi, a.psi_psi);
  if (input) carry_sensor_errors(t, a);
  return t;
}

Translation::Translation(const strapdown::Navigation& nav) {
  const double sin_lat = std::sin(nav.lla[0]), cos_lat = std::cos(nav.lla[0]);
  const strapdown::Radii radii = strapdown::radii(sin_lat, cos_lat);
  const double per_r_t = 1.0 / (radii.transverse + nav.lla[2]);
  W.setZero();
  W(0, 1) = per_r_t;
  W(1, 0) = -1.0 / (radii.meridian + nav.lla[2]);
  W(2, 1) = -per_r_t * sin_lat / cos_lat;
  minus_vW = skew(-nav.v_n) * W;
}

TransitionBlocks translated(const TransitionBlocks& psi, const Translation& before, const Translation& after) {
  TransitionBlocks t = psi;
  t.p_p += psi.p_v * before.minus_vW + psi.p_phi * before.W;
  t.v_p += psi.v_v * before.minus_vW + psi.v_phi * before.W;
  t.phi_p += psi.phi_v * before.minus_vW + psi.phi_phi * before.W;
  const auto back = [&after](const Matrix3d& of_p, Matrix3d& of_v, Matrix3d& of_phi) {
    of_v -= after.minus_vW * of_p;
    of_phi -= after.W * of_p;
  };
  back(t.p_p, t.v_p, t.phi_p);
  back(t.p_v, t.v_v, t.phi_v);
  back(t.p_phi, t.v_phi, t.phi_phi);
  back(t.p_ba, t.v_ba, t.phi_ba);
  back(t.p_sa, t.v_sa, t.phi_sa);
  return t;
}

}  // namespace binnacle::psi_error
