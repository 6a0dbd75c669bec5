// SPDX-License-Identifier: Apache-2.0
// Mounting and lever arm by motion; velocities that contradict the specific force.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "algebra/decompositions.hpp"
#include "lever_arm.hpp"
#include "questions.hpp"
#include "statistics.hpp"
#include "windows.hpp"

namespace binnacle::inspect {

namespace {

double angle_between(const Matrix3d& a, const Matrix3d& b) {
  return std::acos(std::clamp(((a.transpose() * b).trace() - 1) / 2, -1.0, 1.0));
}

/// C_nv of a vehicle that rolls along its velocity, level across.
Matrix3d along(const Vector3d& v) {
  const double course = std::atan2(v[1], v[0]), climb = std::atan2(-v[2], std::hypot(v[0], v[1]));
  return (Eigen::AngleAxisd(course, Vector3d::UnitZ()) * Eigen::AngleAxisd(climb, Vector3d::UnitY()))
      .toRotationMatrix();
}

struct Mean {
  Matrix3d C = Matrix3d::Identity();
  double scatter = 0;  // rad, robust, of windows
  std::size_t windows = 0;
};

/// A rotation for each window, and a mean of these that leaves out those far away.
Mean mounting_of(const Windows& windows, const Vector3d& bias, double least_speed) {
  std::vector<Matrix3d> each;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Matrix3d sum = Matrix3d::Zero();
    int count = 0;
    for (const auto& step : windows.follow(w, bias)) {
      if (std::hypot(step.v[0], step.v[1]) < least_speed) continue;
      sum += along(step.v).transpose() * step.C_nb;
      ++count;
    }
    if (count >= 6) each.push_back(algebra::singular_values(sum).nearest_rotation());
  }
  Mean mean;
  mean.windows = each.size();
  if (each.empty()) return mean;
  // Start: the one nearest to all others (median of rotations), so that reversing does not pull it.
  double least = 1e300;
  for (const auto& a : each) {
    double sum = 0;
    for (const auto& b : each) sum += angle_between(a, b);
    if (sum < least) {
      least = sum;
      mean.C = a;
    }
  }
  for (int pass = 0; pass < 10; ++pass) {
    std::vector<double> away;
    for (const auto& a : each) away.push_back(angle_between(a, mean.C));
    const double scale = std::max(1.4826 * median(away), 1e-6);
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t i = 0; i < each.size(); ++i)
      if (away[i] < 3 * scale) sum += each[i];
    mean.C = algebra::singular_values(sum).nearest_rotation();
    mean.scatter = scale;
  }
  return mean;
}

/// Half of a metre: what a position is to be good to before the antenna's place matters [m].
constexpr double worth_saying = 0.5;

/// In vehicle axes, with the share of the mounting's own error (of each axis) in the covariance.
LeverArm in_vehicle(const LeverArm& of_sensor, const Matrix3d& C_vb, double mounting_error) {
  LeverArm lever_arm = of_sensor;
  lever_arm.value = C_vb * of_sensor.value;
  const Vector3d& l = lever_arm.value;
  lever_arm.covariance = C_vb * of_sensor.covariance * C_vb.transpose() +
                         mounting_error * mounting_error * (l.squaredNorm() * Matrix3d::Identity() - l * l.transpose());
  return lever_arm;
}

void report_lever_arm(const Channel& imu, const Channel& gnss, const LeverArm& lever_arm, Findings& findings) {
  constexpr const char* names[] = {"forward", "right", "down"};
  constexpr const char* sides[] = {"ahead of", "right of", "below", "behind", "left of", "above"};
  for (int k = 0; k < 3; ++k) {
    const double value = lever_arm.value[k], sigma = std::sqrt(lever_arm.covariance(k, k));
    Finding found;
    found.kind = "lever_arm";
    found.channel = imu.name + ", " + gnss.name;
    found.field = names[k];
    found.value = value;
    found.sigma = sigma;
    found.unit = "m";
    const bool is_determined = sigma < worth_saying || std::abs(value) > 4 * sigma;
    found.severity = is_determined ? Severity::finding : Severity::unknown;
    found.text =
        is_determined
            ? fmt::format("the antenna is {:.2f} m {} the IMU (+- {:.2f} m)", std::abs(value),
                          sides[value > 0 ? k : k + 3], sigma)
            : fmt::format("turning does not show where the antenna is: sigma {:.2g} m {}; measure it", sigma, names[k]);
    found.evidence = fmt::format(
        "horizontal velocities in {} windows of 20 s against turning, together with the delay and the biases; sigma by "
        "leaving out a window at a time",
        lever_arm.windows);
    found.confidence = 0.9;
    findings.push_back(std::move(found));
  }
}

void report_level(const Finding& found, const Matrix3d& M, const RestFigures& rest, Findings& findings) {
  if (rest.seconds > 0) {
    Finding level = found;
    level.kind = "mounting_at_rest";
    level.meaning = nullptr;
    const Vector3d up_v = M * rest.mean_f.normalized();
    level.value = degrees * std::acos(std::clamp(-up_v[2], -1.0, 1.0));
    level.text = fmt::format(
        "gravity at rest is {} deg off the vertical of that mounting: slope of the ground and error together",
        figure(level.value));
    level.evidence = fmt::format("mean specific force over {} s of rest", figure(rest.seconds));
    findings.push_back(std::move(level));
  }
}

struct Angles {
  double roll, pitch, yaw;  // rad
};

/// M = Rz(yaw) Ry(pitch) Rx(roll), as rotate_axes takes it.
Angles angles_of(const Matrix3d& M) {
  return {std::atan2(M(2, 1), M(2, 2)), std::asin(std::clamp(-M(2, 0), -1.0, 1.0)), std::atan2(M(1, 0), M(0, 0))};
}

/// The signed order of the sensor's axes that is nearest to a mounting; none where two rows have the same axis.
std::optional<Matrix3d> order_near(const Matrix3d& M) {
  Matrix3d order = Matrix3d::Zero();
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    M.row(row).cwiseAbs().maxCoeff(&column);
    order(row, column) = M(row, column) > 0 ? 1 : -1;
  }
  if (std::abs(order.determinant() - 1) > 0.5) return std::nullopt;
  return order;
}

/// The nearest signed order, where it is beyond doubt: half-way to the next there are 45 deg.
void report_order(const Finding& of, const Matrix3d& M, double error, Findings& findings) {
  const auto near = order_near(M);
  if (!near) return;
  const Matrix3d& order = *near;
  std::string text;
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    order.row(row).cwiseAbs().maxCoeff(&column);
    constexpr const char* names[] = {"forward", "right", "down"};
    text += fmt::format("{}{} is {}{}", row ? ", " : "", names[row], order(row, column) < 0 ? "-" : "+", "xyz"[column]);
  }
  const double off = angle_between(order, M);
  if (off + 3 * error > 45 / degrees) return;
  Finding found = of;
  found.kind = "mounting_axes";
  found.severity = Severity::finding;
  found.value = off * degrees;
  found.unit = "deg";
  found.text =
      fmt::format("of the sensor's axes {}, within {:.0f} deg (+- {:.0f} deg)", text, off * degrees, error * degrees);
  found.evidence =
      "attitudes that fit velocities to specific force, against course and climb; the nearest signed order";
  found.confidence = 0.95;
  findings.push_back(std::move(found));
}

}  // namespace

std::optional<Matrix3d> ask_mounting(const Channel& imu, const Channel& gnss, const Inertial& inertial,
                                     const Fixes& fixes, double delay, const Vector3d& bias, const RestFigures& rest,
                                     Vector3d& lever_arm, LeverArm& antenna, Findings& findings) {
  Windows windows(inertial, fixes, delay, 20);
  const Mean mean = mounting_of(windows, bias, fixes.moving < 3 ? fixes.moving : 5);
  Finding found;
  found.kind = "mounting";
  found.channel = imu.name;
  if (mean.windows < 3) {
    found.severity = Severity::unknown;
    found.text = "there is too little motion to determine the mounting of the sensor";
    findings.push_back(std::move(found));
    return std::nullopt;
  }
  const Matrix3d& M = mean.C;
  const auto [roll, pitch, yaw] = angles_of(M);
  const double error = mean.scatter / std::sqrt(static_cast<double>(mean.windows));
  if (error * degrees > 5) {
    found.severity = Severity::unknown;
    found.text = fmt::format("the motion does not determine the mounting of the sensor: windows differ by {:.0f} deg",
                             mean.scatter * degrees);
    findings.push_back(found);
    report_order(found, M, error, findings);
    return std::nullopt;
  }
  found.value = error * degrees;
  found.unit = "deg";
  found.text = fmt::format(
      "sensor to vehicle axes (forward, right, down): roll {:.2f}, pitch {:.2f}, yaw {:.2f} deg (+- {:.2f} deg)",
      roll * degrees, pitch * degrees, yaw * degrees, error * degrees);
  found.evidence =
      fmt::format("attitudes that fit velocities to specific force, against course and climb, in {} windows",
                  mean.windows);
  found.from = windows.from(0);
  found.to = windows.to(windows.size() - 1);
  found.confidence = 0.95;
  // Angles that the motion cannot distinguish from an order of the axes would be an error of their own.
  const auto order = order_near(M);
  const Angles proposed = order && angle_between(*order, M) < 2 * error ? angles_of(*order) : angles_of(M);
  const auto text = [](double angle) {  // + 0.0: not "-0.00"
    return fmt::format("{:.2f} deg", 0.01 * std::round(100 * angle * degrees) + 0.0);
  };
  found.meaning = {{"transforms",
                    {{"vehicle",
                      {{"type", "rotate_axes"},
                       {"input", imu.name},
                       {"roll", text(proposed.roll)},
                       {"pitch", text(proposed.pitch)},
                       {"yaw", text(proposed.yaw)}}}}}};
  findings.push_back(found);
  report_level(found, M, rest, findings);
  // What velocities are freed from is the lever arm that goes best with this delay.
  if (const LinearFit fit = lever_arm_of(windows, bias, 6); fit.used > 0) lever_arm = fit.beta;
  antenna = find_lever_arm(inertial, fixes, delay, bias);
  if (antenna.windows > 0) report_lever_arm(imu, gnss, in_vehicle(antenna, M, error), findings);
  return M;
}

void ask_velocity_faults(const Channel& gnss, const Inertial& inertial, const Fixes& fixes, double delay,
                         const Vector3d& bias, const Vector3d& lever_arm, Findings& findings,
                         std::vector<Plot>& plots) {
  Windows windows(inertial, fixes, delay, 5);
  windows.set_lever_arm(lever_arm);
  std::vector<double> rms;
  Plot plot{"Velocities against specific force: rms of the residuals in windows of 5 s",
            "time of " + gnss.name + " [s]",
            "m/s",
            {}};
  Plot::Line line{"rms", {}, {}};
  for (std::size_t w = 0; w < windows.size(); ++w) {
    double square = 0, count = 0;
    for (const auto& step : windows.follow(w, bias)) {
      square += step.left.squaredNorm() / (step.doubt * step.doubt);
      count += 3;
    }
    rms.push_back(std::sqrt(square / count));
    line.x.push_back(0.5 * (windows.from(w) + windows.to(w)));
    line.y.push_back(rms.back());
  }
  plot.lines.push_back(std::move(line));
  plots.push_back(std::move(plot));
  if (rms.size() < 8) return;
  std::vector<double> logs;
  for (const double each : rms) logs.push_back(std::log(each));
  // What is left scatters over windows log-normally: five of its sigma are one false window in a million. Four times the usual
  // at least, for records of few windows: set on clean drives, whose worst windows have 2.3 to 3.1 times the usual.
  const double limit = std::exp(median(logs) + std::max(5 * robust_sigma(logs), std::log(4.0)));
  Finding found;
  found.kind = "velocity_fault";
  found.channel = gnss.name;
  found.field = "vn, ve, vd";
  found.unit = "m/s";
  found.value = 0;
  double seconds = 0;
  for (std::size_t w = 0; w < rms.size(); ++w) {
    if (rms[w] < limit) continue;
    if (!std::isfinite(found.from)) found.from = windows.from(w);
    found.to = windows.to(w);
    found.value = std::max(found.value, rms[w]);
    seconds += windows.to(w) - windows.from(w);
  }
  if (!std::isfinite(found.from)) return;
  found.severity = Severity::warning;
  found.confidence = 0.99;
  found.text =
      fmt::format("velocities contradict the specific force for {} s, first at {} s: differences are off by {} m/s rms",
                  figure(seconds), figure(found.from), figure(found.value));
  found.evidence = fmt::format(
      "residuals in windows of 5 s, scaled down where the receiver reports a larger deviation than usual: {} m/s rms "
      "usually, limit {} m/s",
      figure(std::exp(median(logs))), figure(limit));
  findings.push_back(std::move(found));
}

}  // namespace binnacle::inspect
