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

/// F dt of ẋ = F x in (p, u, ψ); its block (p, u) is I dt, (p, ψ), (ψ, p) and (ψ, u) are zero.
struct Generator {
  double dt;
  Matrix3d p_p, u_p, u_u, u_psi, psi_psi;
};

Matrix3d gravity_gradient(const strapdown::Midpoint& mid) {
  Matrix3d G = Matrix3d::Zero();
  G(0, 0) = -mid.g / mid.r_m;
  G(1, 1) = -mid.g / mid.r_t;
  G(2, 0) = mid.g_lat / mid.r_m;
  G(2, 2) = -mid.g_height;
  return G;
}

Generator generator(const strapdown::Midpoint& mid) {
  const double dt = mid.dt;
  return {dt,
          skew(-dt * mid.omega_en_n),
          dt * gravity_gradient(mid),
          skew(-dt * (2.0 * mid.omega_ie_n + mid.omega_en_n)),
          skew(-dt * mid.f_n),
          skew(-dt * (mid.omega_ie_n + mid.omega_en_n))};
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
  t.p_ba = 0.5 * a.dt * t.v_ba, t.p_sa = 0.5 * a.dt * t.v_sa;
  t.v_ba += 0.5 * a.u_u * t.v_ba.eval(), t.v_sa += 0.5 * a.u_u * t.v_sa.eval();
  t.v_bg = 0.5 * a.u_psi * t.phi_bg, t.v_sg = 0.5 * a.u_psi * t.phi_sg;
  t.phi_bg += 0.5 * a.psi_psi * t.phi_bg.eval(), t.phi_sg += 0.5 * a.psi_psi * t.phi_sg.eval();
}

}  // namespace

TransitionBlocks psi_transition(const strapdown::Midpoint& mid, const strapdown::InputSensitivity* input,
                                strapdown::Order order) {
  const Generator a = generator(mid);
  const Matrix3d I = Matrix3d::Identity();
  TransitionBlocks t;
  t.phi_p = t.phi_v = t.p_phi = Matrix3d::Zero();
  t.p_p = I + a.p_p, t.p_v = a.dt * I;
  t.v_p = a.u_p, t.v_v = I + a.u_u, t.v_phi = a.u_psi;
  t.phi_phi = I + a.psi_psi;
  clear_sensor_errors(t);
  if (input) add_sensor_errors(t, mid.C_nb, *input);
  if (order == strapdown::Order::first) return t;

  t.p_p += 0.5 * (a.p_p * a.p_p + a.dt * a.u_p);
  t.p_v += 0.5 * a.dt * (a.p_p + a.u_u);
  t.p_phi = 0.5 * a.dt * a.u_psi;
  t.v_p += 0.5 * (a.u_p * a.p_p + a.u_u * a.u_p);
  t.v_v += 0.5 * (a.dt * a.u_p + a.u_u * a.u_u);
  t.v_phi += 0.5 * (a.u_u * a.u_psi + a.u_psi * a.psi_psi);
  t.phi_phi += 0.5 * a.psi_psi * a.psi_psi;
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
