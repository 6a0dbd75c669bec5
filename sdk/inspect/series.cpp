// SPDX-License-Identifier: Apache-2.0
#include "series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "statistics.hpp"

namespace binnacle::inspect {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<Vector3d> triad(const Channel& channel, const std::vector<std::size_t>& rows, const char* x, const char* y,
                            const char* z) {
  const Field* const fields[] = {channel.find(x), channel.find(y), channel.find(z)};
  std::vector<Vector3d> values(rows.size(), Vector3d::Constant(nan));
  for (int k = 0; k < 3; ++k) {
    if (!fields[k]) continue;
    std::vector<double> column = fields[k]->values;
    double ignored = 0;
    if (channel.is_inertial())
      for (const std::size_t row : spikes(column, ignored)) column[row] = nan;
    for (std::size_t i = 0; i < rows.size(); ++i) values[i][k] = column[rows[i]];
  }
  return values;
}

std::vector<double> doubt_of(const Channel& channel, const std::vector<std::size_t>& rows) {
  std::vector<double> doubt(rows.size(), 1);
  for (const char* name : {"velocity_sd_n", "velocity_sd_e", "velocity_sd_d"}) {
    const Field* const field = channel.find(name);
    if (!field) continue;
    const double usual = median(field->values);
    if (!(usual > 0)) continue;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (const double ratio = field->values[rows[i]] / usual; ratio > doubt[i]) doubt[i] = ratio;
  }
  return doubt;
}

}  // namespace

double usual_step(const std::vector<double>& t) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i)
    if (t[i] > t[i - 1]) steps.push_back(t[i] - t[i - 1]);
  return median(std::move(steps));
}

std::vector<std::size_t> rows_in_order(const std::vector<double>& t) {
  std::vector<std::size_t> rows;
  double newest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (!(t[i] > newest)) continue;
    newest = t[i];
    rows.push_back(i);
  }
  return rows;
}

Inertial inertial_of(const Channel& channel) {
  Inertial inertial;
  const auto rows = rows_in_order(channel.t);
  for (const auto row : rows) inertial.t.push_back(channel.t[row]);
  inertial.w = triad(channel, rows, "wx", "wy", "wz");
  inertial.f = triad(channel, rows, "fx", "fy", "fz");
  inertial.step = usual_step(inertial.t);
  if (channel.find("wx")->kind == FieldKind::increment)
    for (auto& w : inertial.w) w /= inertial.step;
  if (channel.find("fx")->kind == FieldKind::increment)
    for (auto& f : inertial.f) f /= inertial.step;
  return inertial;
}

Fixes fixes_of(const Channel& channel) {
  Fixes fixes;
  const auto rows = rows_in_order(channel.t);
  for (const auto row : rows) fixes.t.push_back(channel.t[row]);
  fixes.v = triad(channel, rows, "vn", "ve", "vd");
  fixes.p = triad(channel, rows, "lat", "lon", "height");
  fixes.doubt = doubt_of(channel, rows);
  fixes.has_velocity = channel.find("vn") && channel.find("ve");
  fixes.has_position = channel.find("lat") && channel.find("lon");
  fixes.has_down = channel.find("vd");
  fixes.has_height = channel.find("height");
  if (!fixes.has_down)
    for (auto& v : fixes.v) v[2] = 0;
  fixes.step = usual_step(fixes.t);
  std::vector<double> speeds;
  for (const auto& v : fixes.v) speeds.push_back(std::hypot(v[0], v[1]));
  if (const double fast = quantile(speeds, 0.9); fast > 0) fixes.moving = std::min(3.0, 0.5 * fast);
  return fixes;
}

Integral::Integral(const std::vector<double>& t, const std::vector<Vector3d>& rate, double step) {
  Vector3d sum = Vector3d::Zero();
  double covered = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double dt = i ? t[i] - t[i - 1] : 0;
    if (dt > 0 && dt < 5 * step && rate[i].allFinite()) {
      sum += rate[i] * dt;
      covered += dt;
    }
    t_.push_back(t[i]);
    sum_.push_back(sum);
    covered_.push_back(covered);
  }
}

Integral::At Integral::at(double t) const {
  if (t_.empty() || t <= t_.front()) return {Vector3d::Zero(), 0};
  if (t >= t_.back()) return {sum_.back(), covered_.back()};
  const auto i = static_cast<std::size_t>(std::ranges::upper_bound(t_, t) - t_.begin());
  const double share = (t - t_[i - 1]) / (t_[i] - t_[i - 1]);
  return {sum_[i - 1] + share * (sum_[i] - sum_[i - 1]), covered_[i - 1] + share * (covered_[i] - covered_[i - 1])};
}

Vector3d Integral::over(double from, double to, double& covered) const {
  const At a = at(from), b = at(to);
  covered = (b.covered - a.covered) / (to - from);
  return b.sum - a.sum;
}

}  // namespace binnacle::inspect
