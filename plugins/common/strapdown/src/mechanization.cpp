// SPDX-License-Identifier: Apache-2.0
// Strapdown mechanization in north-east-down axes.
#include "strapdown/mechanization.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Geometry>

#include "series.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::strapdown {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

double source_length(const Increment& increment) {
  return increment.sample_dt > 0.0 ? increment.sample_dt : increment.dt;
}

/// Constant rates and one sample: the algorithm of a mechanization that nobody chose one for.
BodyMotion integrate_body(const Increment& inc, const MeanRates& neighbour) {
  // Constant rates, exactly: ∫C dt/h = I + (1−cos)/θ² [θ×] + (θ−sin)/θ³ [θ×]², and its like one power of t higher.
  const double theta_squared = inc.dtheta.squaredNorm();
  const double b = detail::angle_minus_sin(theta_squared);
  const Vector3d once = inc.dtheta.cross(inc.dv);
  const Vector3d twice = inc.dtheta.cross(once);
  BodyMotion r{inc.dt, inc.dtheta, inc.dv + detail::one_minus_cos(theta_squared) * once + b * twice,
               inc.dt * (0.5 * inc.dv + b * once + detail::cos_minus_parabola(theta_squared) * twice)};
  if (neighbour.dt > 0.0) {
    const double length = source_length(inc);
    const double weight = length * length / (6.0 * (length + neighbour.dt));  // H²/(12 τ)
    r.rotation += weight * neighbour.omega.cross(inc.dtheta);
    r.velocity += weight * (neighbour.omega.cross(inc.dv) + neighbour.f.cross(inc.dtheta));
    r.position -= weight * (inc.dv - inc.dt * neighbour.f);
  }
  return r;
}

/// The earth under one point, by the sine and cosine of its latitude.
struct Place {
  double sin_lat, cos_lat, inverse_w;
  double inverse_cos_lat, tan_lat;
  Radii radii;
  double r_m, r_t;  ///< m, height included
  double inverse_r_m, inverse_r_t;
  Gravity gravity;

  Vector3d earth_rate() const { return {wgs84::omega_ie * cos_lat, 0.0, -wgs84::omega_ie * sin_lat}; }
  Vector3d transport_rate(const Vector3d& v_n) const {
    const double east = v_n[1] * inverse_r_t;
    return {east, -v_n[0] * inverse_r_m, -east * tan_lat};
  }
};

[[gnu::always_inline]] inline Place place(double sin_lat, double cos_lat, double inverse_w, double height) {
  Place p;
  p.sin_lat = sin_lat;
  p.cos_lat = cos_lat;
  p.inverse_w = inverse_w;
  p.inverse_cos_lat = 1.0 / cos_lat;
  p.tan_lat = sin_lat * p.inverse_cos_lat;
  p.radii = geodesy::radii(sin_lat, cos_lat, inverse_w);
  p.r_m = p.radii.meridian + height;
  p.r_t = p.radii.transverse + height;
  p.inverse_r_m = 1.0 / p.r_m;
  p.inverse_r_t = 1.0 / p.r_t;
  p.gravity = geodesy::gravity(sin_lat, cos_lat, inverse_w, height);
  return p;
}

[[gnu::always_inline]] inline Place place(double lat, double height) {
  const double sin_lat = std::sin(lat);
  return place(sin_lat, std::cos(lat), geodesy::inverse_w(sin_lat), height);
}

/// The place a little to the north (d_lat, rad) and above, by series: relative remainders d_lat⁴/24 and (e² d_lat)³/3.
[[gnu::always_inline]] inline Place moved(const Place& from, double d_lat, double height) {
  const double sine = d_lat * (1.0 - d_lat * d_lat / 6.0);
  const double cosine = 1.0 - 0.5 * d_lat * d_lat;
  const double sin_lat = from.sin_lat * cosine + from.cos_lat * sine;
  const double cos_lat = from.cos_lat * cosine - from.sin_lat * sine;
  const double x = wgs84::e2 * (sin_lat - from.sin_lat) * (sin_lat + from.sin_lat) * from.inverse_w * from.inverse_w;
  return place(sin_lat, cos_lat, from.inverse_w * (1.0 + x * (0.5 + 0.375 * x)), height);
}

/// What the error models need of the place in the middle of a step.
[[gnu::always_inline]] inline void take_place(const Place& middle, Midpoint& mid) {
  mid.sin_lat = middle.sin_lat;
  mid.cos_lat = middle.cos_lat;
  mid.tan_lat = middle.tan_lat;
  mid.r_m = middle.r_m;
  mid.r_t = middle.r_t;
  mid.d_r_m = middle.radii.d_meridian;
  mid.d_r_t = middle.radii.d_transverse;
  mid.g = middle.gravity.down;
  mid.g_lat = middle.gravity.d_lat;
  mid.g_height = middle.gravity.d_height;
}

/// The middle of the shortest turn between two unit quaternions of one hemisphere.
Vector4d halfway(const Vector4d& q, const Vector4d& p) {
  return quaternion_normalised({q[0] + p[0], q[1] + p[1], q[2] + p[2], q[3] + p[3]});
}

double wrapped(double lon) {
  return std::abs(lon) <= std::numbers::pi ? lon : std::remainder(lon, 2.0 * std::numbers::pi);
}

}  // namespace

Previous remember(const Previous& previous, const Increment& increment) {
  const double rate = 1.0 / increment.dt;
  const MeanRates rates{source_length(increment), increment.dtheta * rate, increment.dv * rate};
  return {rates, increment.sample_offset > 0.0 ? previous.before : previous.last};
}

BodyMotion body_motion(const Increment& increment, const MeanRates& neighbour, const attitude::Algorithm& algorithm) {
  BodyMotion r = integrate_body(increment, neighbour);
  if (algorithm.update().precision == attitude::Precision::float_)
    r.rotation = algorithm.rotation(increment.dtheta, source_length(increment), neighbour.omega, neighbour.dt);
  return r;
}

BodyMotion body_motion(std::span<const Increment> increments, const attitude::Algorithm& algorithm) {
  constexpr auto most = static_cast<std::size_t>(attitude::most_samples);
  const std::size_t count = increments.size();
  std::array<double, most> lengths;
  std::array<Vector3d, most> theta, dv;
  double h = 0.0;
  Vector3d turned = Vector3d::Zero(), gained = Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    lengths[i] = increments[i].dt, theta[i] = increments[i].dtheta, dv[i] = increments[i].dv;
    h += lengths[i], turned += theta[i], gained += dv[i];
  }
  attitude::IntervalWeights storage;
  const auto& w = algorithm.weights(std::span(lengths).first(count), storage);
  const std::span<const Vector3d> thetas = std::span(theta).first(count), dvs = std::span(dv).first(count);

  const double squared = turned.squaredNorm();
  const Vector3d once = turned.cross(gained), twice = turned.cross(once);
  Vector3d shifted = Vector3d::Zero();
  for (std::size_t j = 0; j < count; ++j) {
    Vector3d before = w.turned[0][j] * theta[0];
    for (std::size_t i = 1; i < count; ++i) before += w.turned[i][j] * theta[i];
    shifted += w.position[j] * dv[j] + before.cross(dv[j]);
  }
  return {h, algorithm.rotation(thetas, w),
          gained + detail::one_minus_cos(squared) * once + detail::angle_minus_sin(squared) * twice +
              attitude::sculling<double>(thetas, dvs, w.pairs),
          h * (shifted + (detail::angle_minus_sin(squared) - 1.0 / 6.0) * once +
               detail::cos_minus_parabola(squared) * twice)};
}

Step step(const Navigation& nav, const Increment& increment, const Previous& previous) {
  return step(nav, integrate_body(increment, increment.sample_offset > 0.0 ? previous.before : previous.last), {});
}

Step step(const Navigation& nav, const BodyMotion& body, const attitude::Update& update) {
  const double h = body.dt;
  const double height = nav.lla[2];
  const Place start = place(nav.lla[0], height);
  const Eigen::Matrix3d C_nb = dcm_from_quaternion(nav.q_nb);
  const Vector3d u_n = C_nb * body.velocity;
  const Vector3d s_n = C_nb * body.position;

  // Displacement ∫v dt, right to O(h³): gravity and Coriolis, linear in time, weigh on it by their values at h/3.
  const Vector3d rate_ie = start.earth_rate();
  const Vector3d rate_en = start.transport_rate(nav.v_n);
  const double third = h / 3.0;
  Vector3d v_third = nav.v_n + u_n / 3.0;
  v_third[2] += third * start.gravity.down;
  Vector3d other = -(2.0 * rate_ie + start.transport_rate(v_third)).cross(v_third);
  other[2] += start.gravity.down - third * start.gravity.d_height * nav.v_n[2] +
              third * start.gravity.d_lat * nav.v_n[0] * start.inverse_r_m;
  const Vector3d displacement =
      h * nav.v_n + s_n - (h * h / 6.0) * (rate_ie + rate_en).cross(u_n) + (0.5 * h * h) * other;

  // Everything that follows is evaluated in the middle of the step, at its mean velocity.
  const double per_h = 1.0 / h;
  const Vector3d v_mean = displacement * per_h;
  const Place middle = moved(start, 0.5 * displacement[0] * start.inverse_r_m, height - 0.5 * displacement[2]);
  Step r;
  r.mid.omega_ie_n = middle.earth_rate();
  r.mid.omega_en_n = middle.transport_rate(v_mean);
  const Vector3d omega_in = r.mid.omega_ie_n + r.mid.omega_en_n;

  // ∫ t C f dt = h u − S: the turn of the navigation frame since the start of the step (half a step, on average).
  const Vector3d dv_n = u_n - omega_in.cross(h * u_n - s_n);
  r.nav.v_n = nav.v_n + dv_n - h * (omega_in + r.mid.omega_ie_n).cross(v_mean);
  r.nav.v_n[2] += h * middle.gravity.down;

  r.nav.lla = {nav.lla[0] + displacement[0] * middle.inverse_r_m,
               wrapped(nav.lla[1] + displacement[1] * middle.inverse_r_t * middle.inverse_cos_lat),
               height - displacement[2]};

  if (update.is_plain()) {
    r.nav.q_nb = quaternion_normalised(
        quaternion_product(quaternion_product(detail::exp(-h * omega_in), nav.q_nb), detail::exp(body.rotation)));
  } else {
    r.nav.q_nb = update(h * omega_in, nav.q_nb, body.rotation);
  }

  r.mid.dt = h;
  take_place(middle, r.mid);
  r.mid.v_n = v_mean;
  r.mid.f_n = dv_n * per_h;
  r.mid.C_nb = dcm_from_quaternion(halfway(nav.q_nb, r.nav.q_nb));
  return r;
}

Navigation advance(const Navigation& nav, const Increment& increment, const Previous& previous) {
  return step(nav, increment, previous).nav;
}

Navigation advance(const Navigation& nav, std::span<const Increment> increments, Previous previous) {
  Navigation now = nav;
  for (const Increment& increment : increments) {
    now = advance(now, increment, previous);
    previous = remember(previous, increment);
  }
  return now;
}

}  // namespace binnacle::strapdown
