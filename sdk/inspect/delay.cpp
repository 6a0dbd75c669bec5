// SPDX-License-Identifier: Apache-2.0
// Two clocks: turning seen by gyros against turning of the course.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "questions.hpp"
#include "statistics.hpp"
#include "windows.hpp"

namespace binnacle::inspect {

namespace {

struct CourseStep {
  double from, to, rate, weight;
};

std::vector<CourseStep> course_steps(const Fixes& fixes) {
  std::vector<CourseStep> steps;
  for (std::size_t i = 1; i < fixes.t.size(); ++i) {
    const Vector3d &a = fixes.v[i - 1], &b = fixes.v[i];
    const double dt = fixes.t[i] - fixes.t[i - 1];
    const double speed = std::min(std::hypot(a[0], a[1]), std::hypot(b[0], b[1]));
    if (!(speed > fixes.moving) || dt > 3 * fixes.step) continue;
    const double turn = std::remainder(std::atan2(b[1], b[0]) - std::atan2(a[1], a[0]), 6.283185307179586);
    // Beyond 5 m/s^2 hardly any vehicle accelerates: such a step is more likely one of the receiver.
    const double push = (b - a).head<2>().norm() / dt / 5;
    if (std::abs(turn) < 1.2 && push < 2)
      steps.push_back({fixes.t[i - 1], fixes.t[i], turn / dt, std::min(speed, 10.0) / (1 + push * push)});
  }
  return steps;
}

Turning turning_of(const Integral& rates, const std::vector<CourseStep>& steps, double delay, const Vector3d& up) {
  Eigen::MatrixXd X(static_cast<Eigen::Index>(steps.size()), 4);
  Eigen::VectorXd y(static_cast<Eigen::Index>(steps.size()));
  Eigen::Index n = 0;
  for (const CourseStep& step : steps) {
    double covered = 0;
    const Vector3d turn = rates.over(step.from - delay, step.to - delay, covered);
    if (covered < 0.9) continue;
    X.row(n) << step.weight * (turn / (step.to - step.from)).transpose(), step.weight;
    y[n++] = step.weight * step.rate;
  }
  Turning turning;
  turning.used = static_cast<std::size_t>(n);
  if (n < 40) return turning;
  const LinearFit fit = robust_fit(X.topRows(n), y.head(n));
  turning.axis = fit.beta.head<3>();
  turning.axis_error = fit.standard_error.head<3>();
  turning.bias = fit.beta[3];
  turning.explained = fit.explained;
  turning.is_known = fit.explained > 0.5;
  Eigen::MatrixXd vertical(n, 2);
  vertical << X.topLeftCorner(n, 3) * up.normalized(), X.col(3).head(n);
  if (const LinearFit held = robust_fit(vertical, y.head(n)); held.explained > 0.5) {
    turning.along_gravity = std::abs(held.beta[0]);
    turning.along_gravity_error = held.standard_error[0];
  }
  return turning;
}

/// One pass of plain least squares: for searching.
double share_explained(const Integral& rates, const std::vector<CourseStep>& steps, double delay) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double square = 0, sum = 0, weights = 0;
  std::size_t n = 0;
  for (const CourseStep& step : steps) {
    double covered = 0;
    const Vector3d turn = rates.over(step.from - delay, step.to - delay, covered);
    if (covered < 0.9) continue;
    Eigen::Vector4d x;
    x << turn / (step.to - step.from), 1;
    const double w = step.weight * step.weight;
    normal += w * x * x.transpose();
    right += w * step.rate * x;
    square += w * step.rate * step.rate;
    sum += w * step.rate;
    weights += w;
    ++n;
  }
  // A third of the record has to overlap: short overlaps fit by chance.
  if (n < 40 || 3 * n < steps.size()) return 0;
  const double about_mean = square - sum * sum / weights;
  normal.diagonal() *= 1 + 1e-9;
  const double left = square - right.dot(algebra::PivotedCholesky(normal).solve_vector(right));
  return about_mean > 0 ? 1 - left / about_mean : 0;
}

struct Peak {
  double delay = 0, share = -1, second = -1;
};

Peak search(const Integral& rates, const std::vector<CourseStep>& steps, double from, double to, double by,
            Plot* plot) {
  Peak peak;
  std::vector<std::pair<double, double>> all;
  for (double delay = from; delay <= to; delay += by) {
    const double share = share_explained(rates, steps, delay);
    all.emplace_back(delay, share);
    if (share > peak.share) peak = {delay, share, peak.second};
  }
  for (const auto& [delay, share] : all)
    if (std::abs(delay - peak.delay) > 5) peak.second = std::max(peak.second, share);
  if (plot) {
    Plot::Line line{"share of course rate explained", {}, {}};
    for (const auto& [delay, share] : all) {
      line.x.push_back(delay);
      line.y.push_back(share);
    }
    plot->lines.push_back(std::move(line));
  }
  return peak;
}

}  // namespace

Turning turning_at(const Integral& rates, const Fixes& fixes, double delay, const Vector3d& up) {
  return turning_of(rates, course_steps(fixes), delay, up);
}

std::optional<double> ask_clocks(const Channel& imu, const Channel& gnss, const Inertial& inertial, const Fixes& fixes,
                                 double label_difference, Findings& findings, std::vector<Plot>& plots) {
  Finding found;
  found.kind = "overlap";
  found.channel = imu.name + ", " + gnss.name;
  found.unit = "s";
  const double from = std::max(inertial.t.front(), fixes.t.front() + label_difference);
  const double to = std::min(inertial.t.back(), fixes.t.back() + label_difference);
  found.value = std::max(0.0, to - from);
  found.evidence = "first and last labels of both";
  const bool is_short =
      found.value < 0.5 * std::min(inertial.t.back() - inertial.t.front(), fixes.t.back() - fixes.t.front());
  found.severity = is_short ? Severity::warning : Severity::finding;
  found.text = is_short ? fmt::format("labels overlap for {} s only: the clocks differ", figure(found.value))
                        : fmt::format("labels overlap for {} s", figure(found.value));
  findings.push_back(found);
  const auto steps = course_steps(fixes);
  const Integral rates(inertial.t, inertial.w, inertial.step);
  // delay: of labels counted from the first of each channel. Around equal clocks first, then anywhere.
  const double equal = -label_difference;
  Plot plot{"Clocks: what the rates explain of the course rate, by delay",
            "delay of " + gnss.name + " [s]",
            "share",
            {}};
  Peak peak = search(rates, steps, equal - 60, equal + 60, 0.25, &plot);
  if (peak.share < 0.5 || is_short) {
    const double reach = std::max(inertial.t.back(), fixes.t.back());
    const Peak anywhere = search(rates, steps, -reach, reach, 0.25, nullptr);
    if (anywhere.share > peak.share + 0.1) {
      peak = anywhere;
      plot.lines.clear();
      search(rates, steps, peak.delay - 60, peak.delay + 60, 0.25, &plot);
    }
  }
  for (double& x : plot.lines.front().x) x -= equal;
  plots.push_back(std::move(plot));
  if (peak.share < 0.5 || peak.share < peak.second + 0.1) return std::nullopt;
  for (const double by : {0.05, 0.01})
    peak.delay = search(rates, steps, peak.delay - 5 * by, peak.delay + 5 * by, by, nullptr).delay;
  return peak.delay;
}

namespace {

/// What a difference of clocks is known as; exact, where it is that.
struct KnownDelay {
  double seconds = 0;
  const char* name = "";
};
constexpr KnownDelay known_delays[] = {{18, "leap seconds between GPS time and UTC"},
                                       {17, "leap seconds between GPS time and UTC until 2016"},
                                       {315964800, "from the Unix epoch to the GPS epoch"},
                                       {315964782, "from the Unix epoch to the GPS epoch, less 18 leap seconds"},
                                       {3600, "an hour: a time zone"},
                                       {86400, "a day"},
                                       {604800, "a GPS week"}};

const KnownDelay* known_as(double delay) {
  const auto known = std::ranges::find_if(known_delays, [&](const KnownDelay& each) {
    return std::abs(std::abs(delay) - each.seconds) < 0.6;
  });
  return known == std::end(known_delays) ? nullptr : known;
}

std::string name_of(double delay) {
  const KnownDelay* const known = known_as(delay);
  return known ? std::string("; ") + known->name : "";
}

/// The known difference itself where it is within 3 sigma and 0.05 s of what is seen: leap seconds are exact.
double exact(double delay, double sigma) {
  const KnownDelay* const known = known_as(delay);
  if (!known || std::abs(std::abs(delay) - known->seconds) > std::min(3 * sigma, 0.05)) return delay;
  return std::copysign(known->seconds, delay);
}

/// Text files have `time.offset`; receivers have GPS time, to which the other clock is then set.
Json clock_patch(const Channel& imu, const Channel& gnss, double gnss_is_late) {
  const bool sets_gnss = gnss.type == "csv" || imu.type != "csv";
  const Channel& set = sets_gnss ? gnss : imu;
  return source_patch(
      set,
      {{"time", {{"offset", fmt::format("{:.3f} s", set.time_offset + (sets_gnss ? -gnss_is_late : gnss_is_late))}}}});
}

/// Log-likelihood, negative, of what is left of a window, north and east: as the lever arm is fitted.
double horizontal_cost(const std::vector<Windows::Step>& steps) {
  double square = 0;
  for (const auto& step : steps) square += step.left.head<2>().squaredNorm();
  const auto n = static_cast<double>(steps.size());
  return n * std::log(square / (2 * n) + 1e-6);  // 1 mm/s: what velocities are rounded to
}

double total_cost(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias,
                  std::vector<double>* each) {
  Windows windows(inertial, fixes, delay, 20);
  // An antenna behind the sensor turns later, as late fixes do: the lever arm that goes best with this delay is taken off.
  if (windows.size() >= 4) {
    const LinearFit fit = lever_arm_of(windows, bias, 3);
    const bool is_seen =
        fit.used > 0 && fit.beta.norm() < 20 && (fit.beta.cwiseAbs() - 5 * fit.standard_error).maxCoeff() > 0;
    windows.set_lever_arm(is_seen ? Vector3d(fit.beta) : Vector3d::Zero());
  }
  double sum = 0;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const double cost = horizontal_cost(windows.follow(w, bias));
    sum += cost;
    if (each) each->push_back(cost);
  }
  return windows.size() ? sum / static_cast<double>(windows.size()) : 0;
}

}  // namespace

namespace {

/// Less the straight line in t that fits best.
void take_line_off(const Eigen::VectorXd& t, Eigen::VectorXd& y) {
  const Eigen::VectorXd x = t.array() - t.mean();
  y.array() -= y.mean();
  y -= x * (x.dot(y) / x.squaredNorm());
}

}  // namespace

int sign_of_down(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias) {
  // Gravity and horizontal motion rule a window's attitude; what is then left of the vertical shows the sign. Velocities are compared,
  // not their differences: errors of a receiver's velocity are nearly white, so that sums of differences keep the motion and not the
  // errors. The first velocity of a window, and the accelerometers' bias, are a line.
  const Windows windows(inertial, fixes, delay, 20);
  const auto n = static_cast<double>(windows.size());
  if (windows.size() < 4) return 0;
  std::vector<double> roots;
  double mean = 0, square = 0;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const auto steps = windows.follow(w, bias);
    const auto rows = static_cast<Eigen::Index>(steps.size());
    Eigen::VectorXd t(rows), seen(rows), felt(rows);
    double sum_seen = 0, sum_felt = 0;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto& step = steps[static_cast<std::size_t>(i)];
      t[i] = step.t;
      seen[i] = sum_seen += step.sink;
      felt[i] = sum_felt += step.sink - step.left[2];
    }
    take_line_off(t, seen);
    take_line_off(t, felt);
    // (seen + felt)^2 - (seen - felt)^2 = 4 seen felt: the logarithm of the ratio of the signs' likelihoods, but for a factor.
    const double ratio = seen.dot(felt);
    roots.push_back(std::copysign(std::sqrt(std::abs(ratio)), ratio));
    mean += roots.back() / n;
  }
  for (const double root : roots) square += (root - mean) * (root - mean);
  const double lead = mean / std::max(1e-12, std::sqrt(square / (n * (n - 1))));
  if (2 * student_tail(std::abs(lead), roots.size() - 1) > 0.01) return 0;
  return lead > 0 ? 1 : -1;
}

double ask_delay(const Channel& imu, const Channel& gnss, const Inertial& inertial, const Fixes& fixes, double coarse,
                 const Vector3d& bias, double label_difference, Findings& findings) {
  double best = coarse, least = total_cost(inertial, fixes, coarse, bias, nullptr);
  for (const double by : {0.1, 0.02, 0.004})
    for (const double centre = best; const int k : {-8, -7, -6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6, 7, 8})
      if (const double cost = total_cost(inertial, fixes, centre + k * by, bias, nullptr); cost < least) {
        least = cost;
        best = centre + k * by;
      }
  // Sandwich variance over windows, which are independent.
  const double h = 0.04;
  std::vector<double> minus, zero, plus;
  total_cost(inertial, fixes, best - h, bias, &minus);
  total_cost(inertial, fixes, best, bias, &zero);
  total_cost(inertial, fixes, best + h, bias, &plus);
  const std::size_t n = std::min({minus.size(), zero.size(), plus.size()});
  double curvature = 0, square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double g = (plus[i] - minus[i]) / (2 * h);
    square += g * g;
    curvature += (plus[i] - 2 * zero[i] + minus[i]) / (h * h);
  }
  Finding found;
  found.kind = "delay";
  found.channel = imu.name + ", " + gnss.name;
  found.unit = "s";
  found.from = fixes.t.front();
  found.to = fixes.t.back();
  if (n < 3 || curvature <= 0) {
    found.value = coarse + label_difference;
    found.severity = Severity::unknown;
    found.text = "too little motion for the delay between the clocks";
    findings.push_back(std::move(found));
    return coarse;
  }
  const double error = std::sqrt(square) / curvature;
  found.value = best + label_difference;
  found.confidence = 0.99;
  // Beyond a tenth of a second a turn of 20 deg/s bends the course by 2 deg; five standard errors rule out chance.
  const bool matters = std::abs(found.value) > 0.1 && std::abs(found.value) > 5 * error;
  found.severity = matters ? Severity::warning : Severity::finding;
  found.text = fmt::format("{} is {:.3f} s {} {} (+- {:.3f} s){}", gnss.name, std::abs(found.value),
                           found.value > 0 ? "late against" : "early against", imu.name, error, name_of(found.value));
  found.evidence = fmt::format("specific force and turning against velocities, over {} windows of 20 s", n);
  if (matters) found.meaning = clock_patch(imu, gnss, exact(found.value, error));
  findings.push_back(std::move(found));
  return best;
}

}  // namespace binnacle::inspect
