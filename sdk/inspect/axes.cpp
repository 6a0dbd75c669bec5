// SPDX-License-Identifier: Apache-2.0
// Signs and order of axes: of the 48 signed orders of the rates, and of both hands of the forces, those that go with the
// velocities.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include "questions.hpp"
#include "statistics.hpp"
#include "windows.hpp"

namespace binnacle::inspect {

namespace {

std::vector<Matrix3d> signed_orders() {
  std::vector<Matrix3d> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d X = Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) X(row, order[static_cast<std::size_t>(row)]) = signs >> row & 1 ? -1 : 1;
      all.push_back(X);
    }
  } while (std::ranges::next_permutation(order).found);
  return all;
}

/// "x <- +y, y <- +x, z <- +z" where it differs from the identity.
std::string in_words(const Matrix3d& map, const char* letter) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    map.row(row).cwiseAbs().maxCoeff(&column);
    if (column == row && map(row, column) > 0) continue;
    text += fmt::format("{}{}{} is {}{}{}", text.empty() ? "" : ", ", letter, "xyz"[row],
                        map(row, column) < 0 ? "-" : "", letter, "xyz"[column]);
  }
  return text;
}

std::string fields_of(const Matrix3d& map, const char* letter) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    if (map(row, row) != 1) text += fmt::format("{}{}{}", text.empty() ? "" : ", ", letter, "xyz"[row]);
  return text;
}

/// Columns in the order that makes them true, with signs.
Json remedy(const Channel& imu, const Matrix3d& map, char letter) {
  Json columns = Json::object();
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    map.row(row).cwiseAbs().maxCoeff(&column);
    if (column == row && map(row, column) > 0) continue;
    Json& entry = columns[std::string{letter} + "xyz"[row]];
    if (column != row) {
      const Field* const field = imu.find(std::string{letter} + "xyz"[column]);
      entry["column"] = field->column;
    }
    if (map(row, column) < 0) entry["scale"] = -1;
  }
  return source_patch(imu, {{"columns", columns}});
}

void report_triad(const Channel& imu, const char* kind, const Matrix3d& map, char letter, const std::string& what,
                  const std::string& evidence, double confidence, Findings& findings) {
  Finding found;
  found.kind = kind;
  found.channel = imu.name;
  found.field = fields_of(map, std::string(1, letter).c_str());
  found.value = map.determinant();
  found.text = what;
  found.evidence = evidence;
  found.confidence = confidence;
  found.severity = Severity::warning;
  found.meaning = remedy(imu, map, letter);
  findings.push_back(std::move(found));
}

void report_open(const Channel& imu, const std::string& text, const std::string& evidence, Findings& findings) {
  Finding found;
  found.kind = "axes";
  found.channel = imu.name;
  found.severity = Severity::unknown;
  found.text = text;
  found.evidence = evidence;
  findings.push_back(std::move(found));
}

struct Best {
  Matrix3d X;
  bool is_mirrored;
  double lead;           // over the next, in standard errors over windows
  double over_identity;  // over the axes as they are; 0 where these are the best
  std::size_t windows;
  double length = 0;  // of a window, s
  double share = 1;   // of the false decisions allowed
  /// That one so far ahead of 95 others is so by chance.
  double chance(double ahead) const {
    return std::min(1.0, 95 / share * student_tail(std::max(0.0, ahead), windows - 1));
  }
};

Best search(const Windows& windows, const Vector3d& bias) {
  const auto orders = signed_orders();
  const std::size_t n = windows.size();
  std::vector<std::vector<double>> costs(2 * orders.size(), std::vector<double>(n));
  for (std::size_t x = 0; x < orders.size(); ++x)
    for (std::size_t w = 0; w < n; ++w) {
      const auto [plus, minus] = windows.cost(w, orders[x], bias);
      costs[2 * x][w] = plus;
      costs[2 * x + 1][w] = minus;
    }
  const auto sum = [](const std::vector<double>& of) {
    double total = 0;
    for (const double each : of) total += each;
    return total;
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i < costs.size(); ++i)
    if (sum(costs[i]) < sum(costs[best])) best = i;
  // Signed roots of the likelihood ratios: nearly normal, where the ratios themselves have a long tail of windows that show much.
  const auto lead_over = [&](std::size_t i) {
    std::vector<double> roots(n);
    double mean = 0, square = 0;
    for (std::size_t w = 0; w < n; ++w) {
      const double ratio = 2 * (costs[i][w] - costs[best][w]);
      roots[w] = std::copysign(std::sqrt(std::abs(ratio)), ratio);
      mean += roots[w] / static_cast<double>(n);
    }
    for (const double root : roots) square += (root - mean) * (root - mean);
    return mean / std::max(1e-12, std::sqrt(square / static_cast<double>(n * (n - 1))));
  };
  Best result{orders[best / 2], best % 2 == 1, 1e9, 0, n};
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (i == best) continue;
    const double lead = lead_over(i);
    result.lead = std::min(result.lead, lead);
    if (i % 2 == 0 && orders[i / 2].isIdentity()) result.over_identity = lead;
  }
  return result;
}

/// Windows of 40 s: what a turn adds about the level axes grows with the window, and errors of a MEMS gyro stay below a degree. Shorter
/// ones where these do not decide, as on a walk of two minutes; each may be wrong a tenth as often as those before it.
std::optional<Best> search_lengths(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias) {
  std::optional<Best> first;
  double share = 1;
  for (const double length : {40.0, 20.0, 10.0}) {
    const Windows windows(inertial, fixes, delay, length);
    if (windows.size() >= 4) {
      Best best = search(windows, bias);
      best.length = length;
      best.share = share;
      if (best.chance(best.lead) < 0.01) return best;
      if (!first) first = best;
    }
    share /= 10;
  }
  return first;
}

void report_change(const Channel& imu, const Best& best, const std::string& evidence, double confidence, Axes& axes,
                   Findings& list) {
  // f' = P f, w' = Q w, and X = (det P) P Q^-1: the smallest change that explains it.
  const Matrix3d minus_X = -best.X;
  if (best.is_mirrored && best.X.isIdentity()) {
    axes.force = -Matrix3d::Identity();
    report_triad(imu, "force_sign", axes.force, 'f', "specific force has the wrong sign: gravity points down in it",
                 evidence, confidence, list);
  } else if (best.is_mirrored && minus_X.isIdentity()) {
    axes.is_mirrored = true;
    axes.force << 0, 1, 0, 1, 0, 0, 0, 0, 1;
    axes.rate = axes.force;
    report_triad(imu, "mirrored", axes.force, 'f',
                 "the axes are left-handed, of rates and forces alike; exchanging any two, here x and y, remedies it",
                 evidence, confidence, list);
    list.back().meaning.merge_patch(remedy(imu, axes.rate, 'w'));
    list.back().field = "fx, fy, wx, wy";
  } else if (best.is_mirrored) {
    axes.force = minus_X.transpose();
    report_triad(imu, "force_axes", axes.force, 'f', "axes of the specific force: true " + in_words(axes.force, "f"),
                 evidence, confidence, list);
  } else {
    axes.rate = best.X;
    report_triad(imu, minus_X.isIdentity() ? "rate_sign" : "rate_axes", axes.rate, 'w',
                 minus_X.isIdentity() ? "rates have the wrong sign"
                                      : "axes of the rates: true " + in_words(axes.rate, "w"),
                 evidence, confidence, list);
    if (best.X.determinant() > 0 && !best.X.isIdentity())
      list.back().text += "; or those of the forces differ the other way round, which gives the same filter";
  }
}

std::string signed_order_text(const Best& best) {
  const bool is_file = !best.is_mirrored && best.X.isIdentity();
  return std::string("turns and accelerations do not exclude every other order and sign of the axes; ") +
         (is_file
              ? "those of the file fit best, and the mounting is computed with them"
              : "others fit better than those of the file, with which the mounting is computed: check the mounting");
}

}  // namespace

Axes ask_axes(const Channel& imu, const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias,
              Findings* findings) {
  Axes axes;
  Findings ignored;
  Findings& list = findings ? *findings : ignored;
  const std::optional<Best> found_best = search_lengths(inertial, fixes, delay, bias);
  if (!found_best) {
    report_open(imu, "there is too little motion to check the signs and the order of the axes",
                "fewer than four windows of 10 s with velocities", list);
    return axes;
  }
  const Best& best = *found_best;
  const double confidence = 1 - best.chance(best.lead);
  const std::string evidence = fmt::format(
      "rates and forces against velocities in {} windows of {} s: the best of 96 signed orders leads by {} standard "
      "errors",
      best.windows, best.length, figure(best.lead));
  if (confidence < 0.99) {
    axes.is_ruled_out = best.chance(best.over_identity) < 0.01;
    report_open(imu,
                axes.is_ruled_out
                    ? std::string("signs or order of the axes are wrong, and these data do not show which")
                    : signed_order_text(best),
                evidence, list);
    return axes;
  }
  axes.is_known = true;
  if (!best.is_mirrored && best.X.isIdentity()) {
    Finding found;
    found.kind = "axes";
    found.channel = imu.name;
    found.value = best.lead;
    found.unit = "sigma";
    found.text = "rates and specific forces have the same right-handed axes";
    found.evidence = evidence;
    found.confidence = confidence;
    list.push_back(std::move(found));
    return axes;
  }
  report_change(imu, best, evidence, confidence, axes, list);
  return axes;
}

}  // namespace binnacle::inspect
