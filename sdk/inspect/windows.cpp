// SPDX-License-Identifier: Apache-2.0
#include "windows.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "binnacle/geodesy.hpp"

namespace binnacle::inspect {

namespace {

constexpr double piece_length = 0.1;  // s

/// The rotation that turns by this vector.
Matrix3d turned(const Vector3d& by) {
  const double angle = by.norm();
  if (angle < 1e-12) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, by / angle).toRotationMatrix();
}

/// Over what there is of (t - near, t + near].
Vector3d mean_near(const Integral& integral, double t, double near) {
  double covered = 0;
  const Vector3d sum = integral.over(t - near, t + near, covered);
  return covered > 0.1 ? Vector3d(sum / (2 * near * covered)) : Vector3d::Zero();
}

double gravity_at(const Fixes& fixes, std::size_t i) {
  const Vector3d& p = fixes.p[i];
  if (!std::isfinite(p[0]) || std::abs(p[0]) > 1.5708) return 9.80665;
  return geodesy::gravity(p[0], std::isfinite(p[2]) && std::abs(p[2]) < 2e4 ? p[2] : 0).down;
}

}  // namespace

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

void project_out(const Eigen::MatrixXd& of_window, Eigen::Ref<Eigen::MatrixXd> rows, Eigen::Ref<Eigen::VectorXd> left) {
  const algebra::LeastSquares window(of_window);
  rows -= of_window * window.solve(rows);
  left -= of_window * window.solve_vector(left);
}

Windows::Windows(const Inertial& inertial, const Fixes& fixes, double delay, double length, double near) {
  const Integral turns(inertial.t, inertial.w, inertial.step), pushes(inertial.t, inertial.f, inertial.step);
  std::size_t before = 0;
  double last_end = -1e300;
  for (std::size_t i = 1; i < fixes.t.size(); ++i) {
    const double dt = fixes.t[i] - fixes.t[before];
    if (dt < 0.45 && dt < 3 * fixes.step) continue;  // fixes at a high rate: their noise would rule
    const std::size_t a = before;
    before = i;
    if (dt > std::max(2.5, 1.5 * fixes.step) || !fixes.v[a].allFinite() || !fixes.v[i].allFinite()) continue;
    Interval interval{fixes.t[a],
                      fixes.t[i],
                      std::max(fixes.doubt[a], fixes.doubt[i]),
                      fixes.v[i] - fixes.v[a],
                      fixes.v[i],
                      pieces_.size(),
                      0,
                      0,
                      mean_near(turns, fixes.t[a] - delay, near),
                      mean_near(turns, fixes.t[i] - delay, near),
                      mean_near(pushes, fixes.t[a] - delay, near),
                      mean_near(pushes, fixes.t[i] - delay, near)};
    interval.sink = interval.u[2];
    interval.u[2] -= gravity_at(fixes, i) * dt;
    const int count = static_cast<int>(std::ceil(dt / piece_length));
    double least = 1;
    for (int k = 0; k < count; ++k) {
      const double from = fixes.t[a] - delay + dt * k / count, to = fixes.t[a] - delay + dt * (k + 1) / count;
      double covered_w = 0, covered_f = 0;
      Piece piece{turns.over(from, to, covered_w), pushes.over(from, to, covered_f), dt / count};
      least = std::min({least, covered_w, covered_f});
      pieces_.push_back(piece);
    }
    interval.end = pieces_.size();
    if (least < 0.8) {
      pieces_.resize(interval.first);
      continue;
    }
    follows_.push_back(std::abs(interval.from - last_end) < 1e-6);
    last_end = interval.to;
    intervals_.push_back(interval);
  }
  cut(length, std::min(2.0, fixes.moving));
}

void Windows::cut(double length, double least_speed) {
  for (std::size_t i = 0; i < intervals_.size();) {
    std::size_t end = i;
    double top = 0;
    while (end < intervals_.size() && (end == i || follows_[end]) &&
           intervals_[end].to - intervals_[i].from < length + 0.01) {
      top = std::max(top, std::hypot(intervals_[end].v[0], intervals_[end].v[1]));
      ++end;
    }
    if (end - i >= 6 && intervals_[end - 1].to - intervals_[i].from > 0.5 * length && top > least_speed)
      windows_.push_back({i, end, top});
    i = std::max(end, i + 1);
  }
}

Windows::Cost Windows::cost(std::size_t window, const Matrix3d& X, const Vector3d& bias) const {
  Matrix3d C = Matrix3d::Identity(), B = Matrix3d::Zero();
  double squares = 0;
  const bool has_lever_arm = !lever_arm_.isZero();
  const Window& w = windows_[window];
  for (std::size_t i = w.first; i < w.end; ++i) {
    Vector3d s = Vector3d::Zero();
    if (has_lever_arm) s -= C * Vector3d(X * (intervals_[i].rate_begin - bias)).cross(lever_arm_);
    for (std::size_t k = intervals_[i].first; k < intervals_[i].end; ++k) {
      const Vector3d half = 0.5 * (X * (pieces_[k].turn - bias * pieces_[k].dt));
      C = C * turned(half);
      s += C * pieces_[k].push;
      C = C * turned(half);
    }
    if (has_lever_arm) s += C * Vector3d(X * (intervals_[i].rate_end - bias)).cross(lever_arm_);
    B += intervals_[i].u * s.transpose();
    squares += intervals_[i].u.squaredNorm() + s.squaredNorm();
  }
  const algebra::SingularValues singular = algebra::singular_values(B);
  const double handed = singular.handedness();
  const Vector3d sigma = singular.s;
  const double n = static_cast<double>(w.end - w.first);
  const auto likelihood = [&](double sign) {
    const double left = squares - 2 * (sigma[0] + sigma[1] + sign * handed * sigma[2]);
    return 1.5 * n * std::log(std::max(left, 1e-9) / (3 * n) + 1e-6);  // 1 mm/s: what velocities are rounded to
  };
  return {likelihood(1), likelihood(-1)};
}

std::vector<Windows::Step> Windows::follow(std::size_t window, const Vector3d& bias) const {
  Matrix3d C = Matrix3d::Identity(), B = Matrix3d::Zero();
  std::vector<Step> steps;
  std::vector<Vector3d> sums;
  const Window& w = windows_[window];
  for (std::size_t i = w.first; i < w.end; ++i) {
    Vector3d s = Vector3d::Zero();
    Step step{intervals_[i].to,
              intervals_[i].v,
              C,
              Vector3d::Zero(),
              intervals_[i].doubt,
              Vector3d::Zero(),
              Vector3d::Zero(),
              C,
              0,
              Vector3d::Zero()};
    for (std::size_t k = intervals_[i].first; k < intervals_[i].end; ++k) {
      const Vector3d half = 0.5 * (pieces_[k].turn - bias * pieces_[k].dt);
      C = C * turned(half);
      s += C * pieces_[k].push;
      C = C * turned(half);
    }
    step.rate_begin = intervals_[i].rate_begin - bias;
    step.rate_b = intervals_[i].rate_end - bias;
    step.force_begin = intervals_[i].force_begin;
    step.force_b = intervals_[i].force_end;
    s += C * step.rate_b.cross(lever_arm_) - step.C_nb * step.rate_begin.cross(lever_arm_);
    step.C_nb = C;
    B += intervals_[i].u * s.transpose();
    sums.push_back(s);
    steps.push_back(step);
  }
  const Matrix3d R = algebra::singular_values(B).nearest_rotation();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps[i].push = R * sums[i];
    steps[i].left = intervals_[w.first + i].u - steps[i].push;
    steps[i].sink = intervals_[w.first + i].sink;
    steps[i].C_nb = R * steps[i].C_nb;
    steps[i].C_begin = R * steps[i].C_begin;
  }
  return steps;
}

namespace {

/// Rows of one window, north and east of each step: columns of the lever arm, and what is left. What a small rotation of the window
/// explains is projected out of both (Frisch and Waugh). Not down: there pitching alone shows a lever arm, faster than receivers follow.
void add_rows(const std::vector<Windows::Step>& steps, Eigen::Index first, Eigen::MatrixXd& X, Eigen::VectorXd& y) {
  const auto n = static_cast<Eigen::Index>(2 * steps.size());
  Eigen::MatrixXd of_rotation(n, 3);
  auto rows = X.middleRows(first, n);
  auto left = y.segment(first, n);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& step = steps[i];
    const auto row = static_cast<Eigen::Index>(2 * i);
    const Matrix3d turning = step.C_nb * cross_matrix(step.rate_b) - step.C_begin * cross_matrix(step.rate_begin);
    rows.middleRows<2>(row) = turning.topRows<2>() / step.doubt;
    left.segment<2>(row) = step.left.head<2>() / step.doubt;
    of_rotation.middleRows<2>(row) = cross_matrix(step.push).topRows<2>() / step.doubt;
  }
  project_out(of_rotation, rows, left);
}

}  // namespace

LinearFit lever_arm_of(Windows& windows, const Vector3d& bias, int passes) {
  Vector3d lever_arm = Vector3d::Zero();
  LinearFit fit;
  for (int pass = 0; pass < passes; ++pass) {
    windows.set_lever_arm(lever_arm);
    std::vector<std::vector<Windows::Step>> all;
    std::size_t count = 0;
    for (std::size_t w = 0; w < windows.size(); ++w) {
      all.push_back(windows.follow(w, bias));
      count += all.back().size();
    }
    Eigen::MatrixXd X(static_cast<Eigen::Index>(2 * count), 3);
    Eigen::VectorXd y(X.rows());
    Eigen::Index row = 0;
    for (const auto& steps : all) {
      add_rows(steps, row, X, y);
      row += static_cast<Eigen::Index>(2 * steps.size());
    }
    fit = robust_fit(X, y);
    if (fit.used == 0) break;
    lever_arm += fit.beta;
  }
  fit.beta = lever_arm;
  return fit;
}

}  // namespace binnacle::inspect
