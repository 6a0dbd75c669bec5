// SPDX-License-Identifier: Apache-2.0
#include "lever_arm.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "algebra/decompositions.hpp"
#include "inspect/inspect.hpp"
#include "questions.hpp"
#include "statistics.hpp"
#include "windows.hpp"

namespace binnacle::inspect {

namespace {

/// Of all windows: lever arm, delay, bias of the forces, bias of the rates.
constexpr int unknown_count = 10;
using Normal = Eigen::Matrix<double, unknown_count, unknown_count>;
using Unknowns = Eigen::Matrix<double, unknown_count, 1>;

/// Of one window: a small rotation, and the velocity at its begin, north and east.
constexpr int own = 5;

/// What is known before [m, s, m/s^2, rad/s]: wide, so that what the data do not show stays within reason.
Unknowns known_before() {
  Unknowns sigma;
  sigma << 10, 10, 10, 0.3, 0.5, 0.5, 0.5, 0.01, 0.01, 0.01;
  return sigma;
}

struct Rows {
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
};

/// Rows of one window, north and east at each fix. Velocities, not their differences: the errors of fixes are then one each, where a
/// difference shares its own with the next. What the window's own unknowns explain is projected out (Frisch and Waugh).
Rows rows_of(const std::vector<Windows::Step>& steps, double begin) {
  const auto n = static_cast<Eigen::Index>(2 * (steps.size() + 1));
  Rows rows{Eigen::MatrixXd::Zero(n, unknown_count), Eigen::VectorXd::Zero(n)};
  Eigen::MatrixXd of_window = Eigen::MatrixXd::Zero(n, own);
  const auto put = [&](Eigen::Index fix, const Matrix3d& C, const Vector3d& rate, const Vector3d& force, double doubt) {
    rows.X.block<2, 3>(2 * fix, 0) = (C * cross_matrix(rate)).topRows<2>() / doubt;
    rows.X.block<2, 1>(2 * fix, 3) = -(C * force).head<2>() / doubt;
    of_window.block<2, 2>(2 * fix, 3) = Eigen::Matrix2d::Identity() / doubt;
  };
  put(0, steps.front().C_begin, steps.front().rate_begin, steps.front().force_begin, steps.front().doubt);
  Vector3d left = Vector3d::Zero(), push = Vector3d::Zero();
  Matrix3d of_force = Matrix3d::Zero(), turned = Matrix3d::Zero(), of_rate = Matrix3d::Zero();
  double t = begin;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& step = steps[i];
    const auto fix = static_cast<Eigen::Index>(i + 1);
    const Matrix3d C_dt = 0.5 * (step.C_begin + step.C_nb) * (step.t - t);
    t = step.t;
    left += step.left;
    push += step.push;
    of_force += C_dt;
    of_rate += cross_matrix(step.push) * (turned + 0.5 * C_dt);
    turned += C_dt;
    put(fix, step.C_nb, step.rate_b, step.force_b, step.doubt);
    rows.X.block<2, 3>(2 * fix, 4) = of_force.topRows<2>() / step.doubt;
    rows.X.block<2, 3>(2 * fix, 7) = of_rate.topRows<2>() / step.doubt;
    of_window.block<2, 3>(2 * fix, 0) = cross_matrix(push).topRows<2>() / step.doubt;
    rows.y.segment<2>(2 * fix) = left.head<2>() / step.doubt;
  }
  project_out(of_window, rows.X, rows.y);
  return rows;
}

/// The sums of one window, by weights of Tukey's biweight.
struct Sums {
  Normal A = Normal::Zero();
  Unknowns b = Unknowns::Zero();
};

Sums sums_of(const Rows& rows, const Unknowns& x, double sigma) {
  Sums sums;
  const Eigen::VectorXd residual = rows.y - rows.X * x;
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    const double weight = biweight(residual[i], sigma) / (sigma * sigma);
    if (weight == 0) continue;
    sums.A += weight * rows.X.row(i).transpose() * rows.X.row(i);
    sums.b += weight * rows.X.row(i).transpose() * rows.y[i];
  }
  return sums;
}

double sigma_of(const std::vector<Rows>& windows, const Unknowns& x) {
  std::vector<double> away;
  for (const Rows& rows : windows) {
    const Eigen::VectorXd residual = (rows.y - rows.X * x).cwiseAbs();
    away.insert(away.end(), residual.begin(), residual.end());
  }
  return std::max(1.4826 * median(std::move(away)), 1e-4);
}

struct ArmFit {
  Unknowns x = Unknowns::Zero();
  Normal covariance = Normal::Zero();
};

/// `before`: what earlier passes have taken off, which the knowledge before all passes is about.
ArmFit fit_of(const std::vector<Rows>& windows, const Unknowns& before) {
  const Unknowns known = known_before().cwiseAbs2().cwiseInverse();
  ArmFit fit;
  std::vector<Sums> each;
  Sums total;
  for (int pass = 0; pass < 8; ++pass) {
    const double sigma = sigma_of(windows, fit.x);
    each.clear();
    total = {known.asDiagonal(), -known.cwiseProduct(before)};
    for (const Rows& rows : windows) {
      each.push_back(sums_of(rows, fit.x, sigma));
      total.A += each.back().A;
      total.b += each.back().b;
    }
    fit.x = algebra::PivotedCholesky(total.A).solve_vector(total.b);
  }
  // The jackknife: errors that last, of receiver and attitude alike, are in it, as long as they end with a window.
  const Normal inverse = algebra::PivotedCholesky(total.A).solve(Normal::Identity());
  const auto n = static_cast<double>(windows.size());
  for (const Sums& sums : each) {
    const Unknowns moved = algebra::PivotedCholesky(total.A - sums.A).solve_vector(total.b - sums.b) - fit.x;
    fit.covariance += (n - 1) / n * moved * moved.transpose();
  }
  // Where few windows turn, it may be small by chance: not below white errors of each fix. A window's own unknowns leave residuals smaller.
  double rows = 0;
  for (const Rows& each_window : windows) rows += static_cast<double>(each_window.y.size());
  const Unknowns white = inverse.diagonal() * (rows / std::max(1.0, rows - own * n - unknown_count));
  const Unknowns larger = white.cwiseQuotient(fit.covariance.diagonal()).cwiseMax(1).cwiseSqrt();
  fit.covariance = larger.asDiagonal() * fit.covariance * larger.asDiagonal();
  fit.covariance += inverse * known.asDiagonal() * inverse;
  return fit;
}

}  // namespace

namespace {

LeverArm arm_near(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias, double near) {
  LeverArm lever_arm;
  Unknowns taken = Unknowns::Zero();
  ArmFit fit;
  for (int pass = 0; pass < 5; ++pass) {
    Windows windows(inertial, fixes, delay + taken[3], 20, near);
    if (windows.size() < 5) return {};
    windows.set_lever_arm(taken.head<3>());
    std::vector<Rows> rows;
    for (std::size_t w = 0; w < windows.size(); ++w) rows.push_back(rows_of(windows.follow(w, bias), windows.from(w)));
    fit = fit_of(rows, taken);
    taken.head<4>() += fit.x.head<4>();  // the biases are found anew each time
    lever_arm.windows = windows.size();
  }
  lever_arm.value = taken.head<3>();
  lever_arm.covariance = fit.covariance.topLeftCorner<3, 3>();
  return lever_arm;
}

}  // namespace

LeverArm find_lever_arm(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias) {
  // Receivers follow fast motion more or less: some give the velocity of an instant, others a mean over some tenths of a second.
  LeverArm lever_arm = arm_near(inertial, fixes, delay, bias, std::max(0.02, inertial.step));
  if (lever_arm.windows == 0) return lever_arm;
  const Vector3d by_receiver = arm_near(inertial, fixes, delay, bias, 0.15).value - lever_arm.value;
  lever_arm.covariance += by_receiver * by_receiver.transpose() / 3;
  return lever_arm;
}

namespace {

/// One component each, in the filter's axes.
Finding compared(const StatedLeverArm& stated, const SeenLeverArm& seen) {
  const Vector3d value = stated.C_bs * seen.value;
  const Matrix3d covariance = stated.C_bs * seen.covariance * stated.C_bs.transpose();
  const Vector3d sigma = covariance.diagonal().cwiseSqrt();
  const Vector3d away = (stated.value - value).cwiseQuotient(sigma);
  Finding found;
  found.kind = "stated_lever_arm";
  found.channel = seen.imu + ", " + seen.gnss;
  found.value = away.cwiseAbs().maxCoeff();
  found.unit = "sigma";
  found.severity = found.value > 3 ? Severity::warning : Severity::finding;
  found.text = fmt::format(
      "{} has [{:.2f}, {:.2f}, {:.2f}] m; turning shows [{:.2f} +- {:.2f}, {:.2f} +- {:.2f}, {:.2f} +- {:.2f}] m: at "
      "most "
      "{:.1f} sigma off",
      stated.pointer, stated.value[0], stated.value[1], stated.value[2], value[0], sigma[0], value[1], sigma[1],
      value[2], sigma[2], found.value);
  found.evidence =
      fmt::format("differences [{:.1f}, {:.1f}, {:.1f}] sigma, in the axes of the filter", away[0], away[1], away[2]);
  found.confidence = 0.99;
  return found;
}

}  // namespace

void compare_lever_arms(const std::vector<StatedLeverArm>& stated, Inspection& inspection) {
  if (!inspection.lever_arm) return;
  const SeenLeverArm& seen = *inspection.lever_arm;
  for (const StatedLeverArm& each : stated)
    if (each.imu == seen.imu && each.gnss == seen.gnss) inspection.findings.push_back(compared(each, seen));
  sort(inspection.findings);
}

}  // namespace binnacle::inspect
