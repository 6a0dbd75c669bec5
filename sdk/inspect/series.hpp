// SPDX-License-Identifier: Apache-2.0
// Channels as the questions want them: increasing labels, vectors, and integrals over any interval.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "inspect/channel.hpp"

namespace binnacle::inspect {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Median step of the labels that increase, s.
double usual_step(const std::vector<double>& t);
/// Rows whose label is later than all before it.
std::vector<std::size_t> rows_in_order(const std::vector<double>& t);

/// Rates of an inertial channel, rows in order; NaN stays.
struct Inertial {
  std::vector<double> t;    // s, on the first channel's clock once clocks are aligned
  std::vector<Vector3d> w;  // in the stated unit's SI; after correction rad/s
  std::vector<Vector3d> f;
  double step = 0;
};
Inertial inertial_of(const Channel& channel);

struct Fixes {
  std::vector<double> t;
  std::vector<Vector3d> v;    // north, east, down; NaN where there is none
  std::vector<Vector3d> p;    // lat, lon [rad], height
  std::vector<double> doubt;  // stated deviation of the velocity over its median, at least 1; 1 where none is stated
  bool has_velocity = false, has_position = false, has_down = false, has_height = false;
  double step = 0;
  /// m/s: at least so fast, a course is a direction; 3, or less of one who walks: half of the 90th percentile.
  double moving = 3;
};
Fixes fixes_of(const Channel& channel);

/// Integrals of a signal of three components over intervals.
class Integral {
 public:
  Integral(const std::vector<double>& t, const std::vector<Vector3d>& rate, double step);
  /// Over (from, to]; `covered`: which part of it has samples.
  Vector3d over(double from, double to, double& covered) const;

 private:
  struct At {
    Vector3d sum;
    double covered;
  };
  At at(double t) const;
  std::vector<double> t_, covered_;
  std::vector<Vector3d> sum_;
};

}  // namespace binnacle::inspect
