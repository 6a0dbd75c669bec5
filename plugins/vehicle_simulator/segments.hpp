// SPDX-License-Identifier: Apache-2.0
// The segments of a drive: read from the parameters, checked, and resolved into a table.
#pragma once

#include <numbers>
#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle::vehicle_simulator {

inline constexpr double degree = std::numbers::pi / 180;  // [rad]

/// One manoeuvre. acceleration, turn rate and slope follow a Plateau of this height over the segment.
struct Segment {
  Time begin = 0;  // from the start of the drive
  Time duration = 0;
  double ramp = 0.0;          // s
  double speed = 0.0;         // m/s at begin
  double heading = 0.0;       // rad at begin, not wrapped
  double acceleration = 0.0;  // m/s², along the path
  double turn_rate = 0.0;     // rad/s, about down: positive to the right
  double slope = 0.0;         // rad, positive uphill

  double end_speed() const;
  double end_heading() const;
};

/// The parameter `segments`, once for each pass of `repeat`. Throws ComponentError at the member that is
/// wrong.
std::vector<Segment> read_segments(const Parameters& parameters);

/// What one element of `segments` may hold.
std::vector<ParameterSpec> segment_members();

}  // namespace binnacle::vehicle_simulator
