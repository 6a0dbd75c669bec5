// SPDX-License-Identifier: Apache-2.0
// What a receiver observes of the satellites at one instant, and the jumps of its clock.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "binnacle/time.hpp"
#include "gnss/satellite.hpp"

namespace binnacle::gnss {

struct Observation {
  SatelliteKey satellite = 0;
  double pseudorange = std::numeric_limits<double>::quiet_NaN();  // m
  double range_rate = std::numeric_limits<double>::quiet_NaN();   // m/s; a satellite that comes nearer: negative
  double cn0 = std::numeric_limits<double>::quiet_NaN();          // dB-Hz
  double phase = std::numeric_limits<double>::quiet_NaN();        // m
};

struct ObservationEpoch {
  Time t = no_time;
  int line = 0;                                                    // of a text file
  int event = 0;                                                   // 0: nothing; 1: power failure before it
  double clock_offset = std::numeric_limits<double>::quiet_NaN();  // s, as the file gives it
  double clock_jump = 0;  // m, of the receiver's clock since the epoch before, found from code and phase
  std::vector<Observation> satellites;
};

/// [m] from `before` to `now`; 0: it did not jump. Where the receiver sets its clock, every pseudorange jumps and no phase
/// does: the median over satellites of what code minus phase changed by, where that is more than 0.1 ms.
double clock_jump(const ObservationEpoch& before, const ObservationEpoch& now);

/// Fills `clock_jump` of all. A sentence about them: how many, the first; empty where there is none.
struct ClockJumps {
  std::string text;
  int first_line = 0;
};
ClockJumps find_clock_jumps(std::vector<ObservationEpoch>& epochs);

}  // namespace binnacle::gnss
