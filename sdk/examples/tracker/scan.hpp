// SPDX-License-Identifier: Apache-2.0
// A radar's scan: detections by range and bearing, of several targets and of nothing at all.
#pragma once

#include <binnacle/plugin.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "assignment.hpp"

/// With d = p − p_radar of a target, ρ = |d|, β = atan2(d_east, d_north), a detection of it is (ρ, β) + noise. In the
/// residual the bearing is multiplied by the measured range ρ_z, a constant of the sample, so that all rows are metres:
///
///     r = [ρ_z − ρ̂, ρ_z (β_z − β̂)],   H = [dᵀ/ρ; ρ_z (−d_east, d_north)/ρ²],   R = diag(σ_ρ², ρ_z² σ_β²)
///
/// Whose a detection is: squared Mahalanobis distances D² = rᵀ (H P Hᵀ + R)⁻¹ r of all pairs of target and detection, P
/// that of the target's position a priori. A pair beyond the gate is impossible; of the rest the assignment with the
/// least Σ D² is taken, in which a target without detection costs as much as the gate (global nearest neighbour:
/// Blackman, Popoli, Design and Analysis of Modern Tracking Systems, 1999, section 6.4). Detections of no target, clutter,
/// make no rows. The key of a row is the target's number.
class Scan final : public binnacle::MeasurementModel {
 public:
  static constexpr int most_targets = 8;
  static constexpr int most_detections = 64;

  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    using namespace binnacle::parameter;
    ComponentSpec spec;
    spec.type = "scan";
    spec.summary =
        "Ranges and bearings of several targets, and clutter: each detection is given to the target it fits.";
    spec.source = "Blackman, Popoli, Design and Analysis of Modern Tracking Systems, 1999, section 6.4";
    spec.parameters = {vector("radar", "m", 2).defaults("[0, 0]").about("where it stands: north, east"),
                       number("range_sigma", "m").above(0).required().about("of the range's white noise"),
                       number("bearing_sigma", "rad").above(0).required().about("of the bearing's white noise"),
                       number("association", "1")
                           .above(0)
                           .below(1)
                           .defaults("0.999")
                           .about("probability with which a target's own detection lies inside its gate")};
    for (int i = 0; i < most_targets; ++i) {
      PortSpec port = reads(port_name(i), "vector:2:m").about("position of a target: north, east");
      port.is_optional = i > 0;
      spec.ports.push_back(std::move(port));
    }
    spec.fields = {field::level("range", "m").per_row().about("from the radar"),
                   field::level("bearing", "rad").per_row().about("clockwise from north")};
    spec.example = R"json({"channel": "scan", "blocks": {"target_1": "car", "target_2": "truck"},
      "range_sigma": "5 m", "bearing_sigma": "0.3 deg"})json";
    spec.surroundings = R"json({"blocks": {
        "car": {"type": "vector", "size": 2, "unit": "m", "init": {"x0": 3000, "x1": 100}, "sigma": 20},
        "truck": {"type": "vector", "size": 2, "unit": "m", "init": {"x0": -500, "x1": 2000}, "sigma": 20}},
      "sample": {"range": [2070, 4000, 2995], "bearing": [1.815, -2.5, 0.035]}})json";
    return spec;
  }

  explicit Scan(const binnacle::Binding& b)
      : range_(b.row_field("range")),
        bearing_(b.row_field("bearing")),
        radar_(b.parameters().vector("radar")),
        range_sigma_(b.parameters().number("range_sigma")),
        bearing_sigma_(b.parameters().number("bearing_sigma")),
        gate_(-2 * std::log1p(-b.parameters().number("association"))) {  // χ² of two degrees of freedom
    int bound = 0;
    for (int i = 0; i < most_targets; ++i) {
      const binnacle::Port target = b.port(port_name(i));
      targets_[index(i)] = target;
      declaration_.reads(target);
      bound += target.is_bound();
    }
    declaration_.rows(2 * bound).group(binnacle::rows::like("detection", "m")).wants_covariance();
  }

  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    using binnacle::Result;
    const int detections = in.sample.rows;
    if (!in.P) return Result::failed("association needs the covariance of the targets");
    if (detections > most_detections) return Result::invalid("more than 64 detections");
    for (int k = 0; k < detections; ++k)
      if (!is_usable(in.sample(k, range_), in.sample(k, bearing_)))
        return Result::invalid("a detection has a range above zero and a finite bearing");

    // Columns: the detections, then for each target that of going without.
    constexpr std::size_t columns = most_detections + most_targets;
    Assignment<most_targets, columns> assignment(most_targets, index(detections + most_targets));
    for (int i = 0; i < most_targets; ++i)
      for (int k = 0; k < detections + most_targets; ++k)
        assignment.cost(index(i), index(k)) = k < detections        ? cost(in, i, k)
                                              : k == detections + i ? gate_
                                                                    : impossible;
    const auto column_of = assignment.solve();

    out.rows = 0;
    for (int i = 0; i < most_targets; ++i) {
      const int k = static_cast<int>(column_of[index(i)]);
      if (k < detections) write(seen(in, i, k), targets_[index(i)], i + 1, out);
    }
    return Result::ok();
  }

 private:
  using Matrix2 = Eigen::Matrix2d;
  using Vector2 = Eigen::Vector2d;
  static constexpr double impossible = 1e12;  // more than any sum of gates

  struct Pair {
    Vector2 residual;  // m
    Matrix2 H;
    Vector2 R;  // its diagonal [m²]
  };

  static std::string port_name(int i) { return "target_" + std::to_string(i + 1); }
  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static bool is_usable(double range, double bearing) {
    return range > 0 && range < 1e9 && std::isfinite(bearing) && std::abs(bearing) < 1e3;
  }

  /// Detection k as that of target i.
  Pair seen(const binnacle::MeasurementInput& in, int i, int k) const {
    const double range = in.sample(k, range_), bearing = in.sample(k, bearing_);
    const Vector2 d = in.x[targets_[index(i)]].as<2>() - radar_;
    const double distance = d.norm();
    Pair pair;
    pair.residual << range - distance, range * std::remainder(bearing - std::atan2(d[1], d[0]), 2 * std::numbers::pi);
    const double turn = range / (distance * distance);
    pair.H << d[0] / distance, d[1] / distance, -d[1] * turn, d[0] * turn;
    pair.R << range_sigma_ * range_sigma_, std::pow(range * bearing_sigma_, 2);
    return pair;
  }

  /// D², or impossible: an open port, a target on the radar itself, a pair beyond the gate.
  double cost(const binnacle::MeasurementInput& in, int i, int k) const {
    const binnacle::Port target = targets_[index(i)];
    if (!target.is_bound()) return impossible;
    const double distance = (in.x[target].as<2>() - radar_).norm();
    if (!(distance > 1e-3) || !(distance < 1e9)) return impossible;
    const Pair pair = seen(in, i, k);
    Matrix2 S = pair.H * in.P(target, target).as<2, 2>() * pair.H.transpose();
    S.diagonal() += pair.R;
    const double determinant = S(0, 0) * S(1, 1) - S(0, 1) * S(0, 1);
    if (!(determinant > 0)) return impossible;
    const Vector2 r = pair.residual;
    const double D2 = (S(1, 1) * r[0] * r[0] - 2 * S(0, 1) * r[0] * r[1] + S(0, 0) * r[1] * r[1]) / determinant;
    return D2 <= gate_ ? D2 : impossible;
  }

  static void write(const Pair& pair, binnacle::Port target, int number, binnacle::MeasurementOutput& out) {
    const int first = out.rows;
    out.rows += 2;
    for (int row = 0; row < 2; ++row) {
      out.residual[first + row] = pair.residual[row];
      out.R(first + row, first + row) = pair.R[row];
      out.row_keys[index(first + row)] = number;
    }
    if (auto H = out.H[target]) H.block(first, 0, 2, 2).as<2, 2>() = pair.H;
  }

  std::array<binnacle::Port, most_targets> targets_;
  binnacle::RowField range_, bearing_;
  Vector2 radar_;         // m
  double range_sigma_;    // m
  double bearing_sigma_;  // rad
  double gate_;
};
