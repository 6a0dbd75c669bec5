// SPDX-License-Identifier: Apache-2.0
// The tilt (phi) error model of the NED mechanization.
#include "strapdown/error_model.hpp"

#include <Eigen/Geometry>

#include "strapdown/rotation.hpp"

namespace binnacle::strapdown {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void set_columns(Matrix3d& m, const Vector3d& north, const Vector3d& east, const Vector3d& down) {
  m.col(0) = north;
  m.col(1) = east;
  m.col(2) = down;
}

void add_identity(Matrix3d& m) {
  for (int j = 0; j < 3; ++j) {
    m(j, j) += 1.0;
  }
}

/// A column of a matrix on x = (p, v, phi).
struct Column {
  Vector3d p, v, phi;
};

/// A = F dt of ẋ = F x, at the middle of the step, by what of it is not zero:
///        | P   I dt    0    |    P:  its east column holds east_east alone, its down row is zero
///   A =  | ·   v_v  −[f×]   |    the position columns are `north` and `down`; east but for east_east is zero
///        | ·  −W dt −[w×]   |    W = ∂ω_en/∂v = [0 1/r_t 0; −1/r_m 0 0; 0 −tan L/r_t 0]
struct Generator {
  double dt;
  Column north, down;
  double east_east;
  Matrix3d v_v;
  Vector3d f, w;                ///< f_n dt, omega_in dt
  double dt_r_m, dt_r_t, dt_t;  ///< dt/r_m, dt/r_t, dt tan L/r_t

  Vector3d minus_W(const Vector3d& v) const { return {-dt_r_t * v[1], dt_r_m * v[0], dt_t * v[1]}; }
  /// A (0, v, phi)ᵀ
  Column of(const Vector3d& v, const Vector3d& phi) const {
    return {dt * v, v_v * v - f.cross(phi), minus_W(v) - w.cross(phi)};
  }
};

/// P, with r_m = R_m + h, r_t = R_t + h and the chart δN = r_m δL, δE = r_t cos L δl, δD = −δh, which is paper 003 (1)
/// in metres:
///   d(δN)/dt = δv_N + (dr_m/dt) δL − L̇ (R_m' δL + δh),  dr_m/dt = R_m' L̇ + ḣ: R_m' cancels;
///   d(δE)/dt likewise, where d(R_t cos L)/dL = −R_m sin L makes R_t' cancel too.
Generator generator(const Midpoint& mid) {
  const double dt = mid.dt, t = mid.tan_lat;
  const double v_north = mid.v_n[0], v_east = mid.v_n[1], v_down = mid.v_n[2];
  const double per_r_m = 1.0 / mid.r_m, per_r_t = 1.0 / mid.r_t;
  const double north_rate = v_north * per_r_m, east_rate = v_east * per_r_t;

  // ∂ω_ie/∂N, ∂ω_en/∂N and ∂ω_en/∂D, times dt: ∂/∂N = (1/r_m) ∂/∂L, ∂/∂D = −∂/∂h.
  const double dt_m = dt * per_r_m;
  const Vector3d ie_north{dt_m * mid.omega_ie_n[2], 0.0, -dt_m * mid.omega_ie_n[0]};
  const double en_slope = east_rate * mid.d_r_t * per_r_t;
  const Vector3d en_north{-dt_m * en_slope, dt_m * north_rate * mid.d_r_m * per_r_m,
                          dt_m * (t * en_slope - east_rate * (1.0 + t * t))};
  const double dt_t = dt * per_r_t;
  const Vector3d en_down{dt_t * east_rate, -dt_m * north_rate, -dt_t * t * east_rate};

  Generator a;
  a.dt = dt;
  a.north.p = {-dt_m * v_down, dt * t * east_rate, 0.0};
  a.north.v = mid.v_n.cross(2.0 * ie_north + en_north);
  a.north.v[2] += dt_m * mid.g_lat;
  a.north.phi = -(ie_north + en_north);
  a.east_east = -dt_t * (v_north * t + v_down);
  a.down.p = {dt * north_rate, dt * east_rate, 0.0};
  a.down.v = mid.v_n.cross(en_down);
  a.down.v[2] -= dt * mid.g_height;
  a.down.phi = -en_down;
  a.f = dt * mid.f_n;
  a.w = dt * (mid.omega_ie_n + mid.omega_en_n);
  a.dt_r_m = dt_m;
  a.dt_r_t = dt_t;
  a.dt_t = t * dt_t;
  // −[(2ω_ie + ω_en)×] + [v×] W
  a.v_v = skew(-dt * (2.0 * mid.omega_ie_n + mid.omega_en_n));
  a.v_v.col(0) += mid.v_n.cross(Vector3d{0.0, -a.dt_r_m, 0.0});
  a.v_v.col(1) += mid.v_n.cross(Vector3d{a.dt_r_t, 0.0, -a.dt_t});
  return a;
}

TransitionBlocks first_order(const Generator& a, const Midpoint& mid, const InputSensitivity& input) {
  const Matrix3d zero = Matrix3d::Zero();
  TransitionBlocks t;
  set_columns(t.p_p, a.north.p, Vector3d{0.0, a.east_east, 0.0}, a.down.p);
  add_identity(t.p_p);
  t.p_v = a.dt * Matrix3d::Identity();
  t.p_phi = t.p_ba = t.p_sa = zero;
  set_columns(t.v_p, a.north.v, Vector3d::Zero(), a.down.v);
  t.v_v = Matrix3d::Identity() + a.v_v;
  t.v_phi = skew(-a.f);
  t.v_bg = t.v_sg = zero;
  t.v_ba = mid.C_nb * input.accel_bias.asDiagonal();
  t.v_sa = mid.C_nb * input.accel_scale.asDiagonal();
  set_columns(t.phi_p, a.north.phi, Vector3d::Zero(), a.down.phi);
  set_columns(t.phi_v, a.minus_W(Vector3d::UnitX()), a.minus_W(Vector3d::UnitY()), Vector3d::Zero());
  t.phi_phi = Matrix3d::Identity() + skew(-a.w);
  t.phi_bg = mid.C_nb * input.gyro_bias.asDiagonal();
  t.phi_sg = mid.C_nb * input.gyro_scale.asDiagonal();
  t.phi_ba = t.phi_sa = zero;
  return t;
}

/// x + ½ A x for a position column x of A.
Column carried(const Generator& a, const Column& x) {
  const Column image = a.of(x.v, x.phi);
  Column r{x.p + 0.5 * (image.p + x.p[0] * a.north.p), x.v + 0.5 * (image.v + x.p[0] * a.north.v),
           x.phi + 0.5 * (image.phi + x.p[0] * a.north.phi)};
  r.p[1] += 0.5 * a.east_east * x.p[1];
  return r;
}

/// [a×][b×] = b aᵀ − (a·b) I
Matrix3d cross_cross(const Vector3d& a, const Vector3d& b) {
  const double dot = a.dot(b);
  Matrix3d m;
  for (int j = 0; j < 3; ++j) {
    m.col(j) = b * a[j];
    m(j, j) -= dot;
  }
  return m;
}

/// M [a×]: its rows are those of M crossed with a.
Matrix3d times_cross(const Matrix3d& m, const Vector3d& a) {
  Matrix3d r;
  set_columns(r, m.col(1) * a[2] - m.col(2) * a[1], m.col(2) * a[0] - m.col(0) * a[2],
              m.col(0) * a[1] - m.col(1) * a[0]);
  return r;
}

/// [a×] M: its columns are a crossed with those of M.
Matrix3d cross_times(const Vector3d& a, const Matrix3d& m) {
  Matrix3d r;
  set_columns(r, a.cross(m.col(0)), a.cross(m.col(1)), a.cross(m.col(2)));
  return r;
}

TransitionBlocks second_order(const Generator& a, const Midpoint& mid, const InputSensitivity& input) {
  TransitionBlocks t;
  const double half_dt = 0.5 * a.dt;

  const Column north = carried(a, a.north), down = carried(a, a.down);
  set_columns(t.p_p, north.p, Vector3d{0.0, a.east_east * (1.0 + 0.5 * a.east_east), 0.0}, down.p);
  set_columns(t.v_p, north.v, Vector3d::Zero(), down.v);
  set_columns(t.phi_p, north.phi, Vector3d::Zero(), down.phi);
  add_identity(t.p_p);

  // Velocity columns A (I dt, v_v, −W dt): the position part passes through the columns north and down and east_east.
  const Vector3d W_north{0.0, -a.dt_r_m, 0.0}, W_east{a.dt_r_t, 0.0, -a.dt_t};  // W dt, by columns
  const Matrix3d& V = a.v_v;
  set_columns(t.p_v, half_dt * (V.col(0) + a.north.p), half_dt * V.col(1), half_dt * (V.col(2) + a.down.p));
  t.p_v(1, 1) += half_dt * a.east_east;
  set_columns(t.v_v, V.col(0) + 0.5 * (V * V.col(0) + a.f.cross(W_north) + a.dt * a.north.v),
              V.col(1) + 0.5 * (V * V.col(1) + a.f.cross(W_east)), V.col(2) + 0.5 * (V * V.col(2) + a.dt * a.down.v));
  set_columns(t.phi_v, -W_north + 0.5 * (a.minus_W(V.col(0)) + a.w.cross(W_north) + a.dt * a.north.phi),
              -W_east + 0.5 * (a.minus_W(V.col(1)) + a.w.cross(W_east)),
              0.5 * (a.minus_W(V.col(2)) + a.dt * a.down.phi));
  for (int j = 0; j < 3; ++j) {
    t.p_v(j, j) += a.dt;
  }
  add_identity(t.v_v);

  // Attitude columns A (0, −[f×], −[w×]).
  const Matrix3d minus_f = skew(-a.f);
  Matrix3d W_cross_f;  // W dt [f×]
  set_columns(W_cross_f, Vector3d{a.dt_r_t * a.f[2], 0.0, -a.dt_t * a.f[2]}, Vector3d{0.0, a.dt_r_m * a.f[2], 0.0},
              Vector3d{-a.dt_r_t * a.f[0], -a.dt_r_m * a.f[1], a.dt_t * a.f[0]});
  t.p_phi = half_dt * minus_f;
  t.v_phi = minus_f + 0.5 * (cross_cross(a.f, a.w) - times_cross(V, a.f));
  t.phi_phi = skew(-a.w) + 0.5 * (W_cross_f + cross_cross(a.w, a.w));
  add_identity(t.phi_phi);

  // An input error enters through C and is then carried for half a step: (I + ½ A) C.
  for (int j = 0; j < 3; ++j) {
    const Vector3d axis = mid.C_nb.col(j), half = 0.5 * axis;
    const Vector3d turned = axis - a.w.cross(half), tilted = -a.f.cross(half);
    const Vector3d pushed = axis + a.v_v * half, transported = a.minus_W(half), moved = a.dt * half;
    t.phi_bg.col(j) = turned * input.gyro_bias[j];
    t.phi_sg.col(j) = turned * input.gyro_scale[j];
    t.v_bg.col(j) = tilted * input.gyro_bias[j];
    t.v_sg.col(j) = tilted * input.gyro_scale[j];
    t.v_ba.col(j) = pushed * input.accel_bias[j];
    t.v_sa.col(j) = pushed * input.accel_scale[j];
    t.p_ba.col(j) = moved * input.accel_bias[j];
    t.p_sa.col(j) = moved * input.accel_scale[j];
    t.phi_ba.col(j) = transported * input.accel_bias[j];
    t.phi_sa.col(j) = transported * input.accel_scale[j];
  }
  return t;
}

}  // namespace

Increment correct(const Increment& measured, const SensorErrors& errors) {
  Increment r = measured;
  r.dtheta = (measured.dtheta - errors.gyro_bias * measured.dt).array() / (1.0 + errors.gyro_scale.array());
  r.dv = (measured.dv - errors.accel_bias * measured.dt).array() / (1.0 + errors.accel_scale.array());
  return r;
}

InputSensitivity input_sensitivity(const Increment& corrected, const SensorErrors& errors) {
  const Vector3d gyro = -(1.0 + errors.gyro_scale.array()).inverse();
  const Vector3d accel = -(1.0 + errors.accel_scale.array()).inverse();
  return {corrected.dt * gyro, corrected.dtheta.cwiseProduct(gyro), corrected.dt * accel,
          corrected.dv.cwiseProduct(accel)};
}

TransitionBlocks transition(const Midpoint& mid, const InputSensitivity& input, Order order) {
  const Generator a = generator(mid);
  return order == Order::first ? first_order(a, mid, input) : second_order(a, mid, input);
}

NoiseBlocks process_noise(const Midpoint& mid, const NoiseDensity& density, bool with_position) {
  const double h = mid.dt;
  const Matrix3d gyro = mid.C_nb * density.gyro.asDiagonal() * mid.C_nb.transpose();
  const Matrix3d k_gyro = cross_times(mid.f_n, gyro);
  const Matrix3d k_gyro_k = -times_cross(k_gyro, mid.f_n);
  Matrix3d accel = mid.C_nb * density.accel.asDiagonal() * mid.C_nb.transpose();
  if (density.turned_squared > 0.0) accel += density.turned_squared * k_gyro_k;
  const double h2 = h * h;
  const double h3 = h2 * h;
  NoiseBlocks q;
  if (with_position) {
    q.p_p = (h3 / 3.0) * accel + (h3 * h2 / 20.0) * k_gyro_k;
    q.p_v = (h2 / 2.0) * accel + (h2 * h2 / 8.0) * k_gyro_k;
    q.p_phi = (-h3 / 6.0) * k_gyro;
  }
  q.v_v = h * accel + (h3 / 3.0) * k_gyro_k;
  q.v_phi = (-h2 / 2.0) * k_gyro;
  q.phi_phi = h * gyro;
  return q;
}

}  // namespace binnacle::strapdown
