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

/// The diagonal and (2, 0) of a G; its other elements are zero.
struct GravityGradient {
  double north, east, down, down_north;
};

/// F dt of ẋ = F x in (p, u, ψ), by the vectors a of [a×] where a block is that; its block (p, u) is I dt, (p, ψ),
/// (ψ, p) and (ψ, u) are zero.
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
          {dt * (-mid.g / mid.r_m), dt * (-mid.g / mid.r_t), dt * -mid.g_height, dt * (mid.g_lat / mid.r_m)},
          -dt * (2.0 * mid.omega_ie_n + mid.omega_en_n),
          -dt * mid.f_n,
          -dt * (mid.omega_ie_n + mid.omega_en_n)};
}

// Sums element by element: what is zero is left out, and a matrix that is written once is not read again.

/// G
Matrix3d gravity(const GravityGradient& g) {
  Matrix3d m;
  m << g.north, 0, 0, 0, g.east, 0, g.down_north, 0, g.down;
  return m;
}

/// s I + [a×]
Matrix3d turned(double s, const Vector3d& a) {
  Matrix3d m;
  m << s, -a[2], a[1], a[2], s, -a[0], -a[1], a[0], s;
  return m;
}

/// I + [a×] + ½([a×]² + G)
Matrix3d turned_twice(const Vector3d& a, const GravityGradient& g) {
  const double xx = a[0] * a[0], yy = a[1] * a[1], zz = a[2] * a[2];
  const double xy = 0.5 * (a[0] * a[1]), xz = 0.5 * (a[0] * a[2]), yz = 0.5 * (a[1] * a[2]);
  Matrix3d m;
  m << 1 + 0.5 * (g.north - (yy + zz)), -a[2] + xy, a[1] + xz,  //
      a[2] + xy, 1 + 0.5 * (g.east - (xx + zz)), -a[0] + yz,    //
      -a[1] + 0.5 * (a[0] * a[2] + g.down_north), a[0] + yz, 1 + 0.5 * (g.down - (xx + yy));
  return m;
}

/// G + ½(G [a×] + [b×] G)
Matrix3d carried(const GravityGradient& g, const Vector3d& a, const Vector3d& b) {
  Matrix3d m;
  m << g.north + 0.5 * (b[1] * g.down_north), 0.5 * (g.north * -a[2] + -b[2] * g.east),
      0.5 * (g.north * a[1] + b[1] * g.down),  //
      0.5 * (g.east * a[2] + (b[2] * g.north + -b[0] * g.down_north)), g.east,
      0.5 * (g.east * -a[0] + -b[0] * g.down),  //
      g.down_north + 0.5 * (g.down * -a[1] + -b[1] * g.north),
      0.5 * ((g.down_north * -a[2] + g.down * a[0]) + b[0] * g.east), g.down + 0.5 * (g.down_north * a[1]);
  return m;
}

/// [f×] + ½([a×][f×] + [f×][b×]), where [a×][f×] = f aᵀ − (a·f) I
Matrix3d tilted(const Vector3d& f, const Vector3d& a, const Vector3d& b) {
  const double x = a[0] * f[0], y = a[1] * f[1], z = a[2] * f[2];
  const double u = f[0] * b[0], v = f[1] * b[1], w = f[2] * b[2];
  Matrix3d m;
  m << 0.5 * (-(y + z) - (v + w)), -f[2] + 0.5 * (a[1] * f[0] + f[1] * b[0]),
      f[1] + 0.5 * (a[2] * f[0] + f[2] * b[0]),  //
      f[2] + 0.5 * (a[0] * f[1] + f[0] * b[1]), 0.5 * (-(x + z) - (u + w)),
      -f[0] + 0.5 * (a[2] * f[1] + f[2] * b[1]),  //
      -f[1] + 0.5 * (a[0] * f[2] + f[0] * b[2]), f[0] + 0.5 * (a[1] * f[2] + f[1] * b[2]), 0.5 * (-(x + y) - (u + v));
  return m;
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
                                strapdown::Order order, bool with_position) {
  const Generator a = generator(mid);
  TransitionBlocks t;
  t.phi_p.setZero(), t.phi_v.setZero();
  if (input) {
    clear_sensor_errors(t);
    add_sensor_errors(t, mid.C_nb, *input);
  }
  if (order == strapdown::Order::first) {
    t.p_p = turned(1, a.p_p), t.p_v = turned(a.dt, Vector3d::Zero()), t.p_phi.setZero();
    t.v_p = gravity(a.u_p), t.v_v = turned(1, a.u_u), t.v_phi = turned(0, a.u_psi);
    t.phi_phi = turned(1, a.psi_psi);
    return t;
  }
  const double half_dt = 0.5 * a.dt;
  const GravityGradient dt_u_p{a.dt * a.u_p.north, a.dt * a.u_p.east, a.dt * a.u_p.down, a.dt * a.u_p.down_north};
  if (with_position) {
    t.p_p = turned_twice(a.p_p, dt_u_p), t.p_v = turned(a.dt, half_dt * (a.p_p + a.u_u));
    t.p_phi = turned(0, half_dt * a.u_psi);
    t.v_p = carried(a.u_p, a.p_p, a.u_u);
  }
  t.v_v = turned_twice(a.u_u, dt_u_p);
  t.v_phi = tilted(a.u_psi, a.u_u, a.psi_psi);
  t.phi_phi = turned_twice(a.psi_psi, {});
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

TransitionBlocks translated(const TransitionBlocks& psi, const Translation& before, const Translation& after,
                            bool has_sensor_errors) {
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
  if (!has_sensor_errors) return t;
  back(t.p_ba, t.v_ba, t.phi_ba);
  back(t.p_sa, t.v_sa, t.phi_sa);
  return t;
}

}  // namespace binnacle::psi_error
