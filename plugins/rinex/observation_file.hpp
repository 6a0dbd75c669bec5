// SPDX-License-Identifier: Apache-2.0
// Epochs of a RINEX observation file.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "faults.hpp"
#include "gnss/satellite.hpp"

namespace binnacle::rinex {

/// Which observations are taken: those whose code ends so ("1C": C1C, D1C, S1C, L1C; in RINEX 2 C1, D1, S1, L1).
/// An empty code: none of this constellation.
struct Signals {
  std::string gps = "1C";
  std::string galileo = "1C";

  const std::string& of(gnss::Constellation constellation) const {
    return constellation == gnss::Constellation::galileo ? galileo : gps;
  }
};

struct Observation {
  gnss::SatelliteKey satellite = 0;
  double pseudorange = std::numeric_limits<double>::quiet_NaN();  // m
  double range_rate = std::numeric_limits<double>::quiet_NaN();   // m/s
  double cn0 = std::numeric_limits<double>::quiet_NaN();          // dB-Hz
  double phase = std::numeric_limits<double>::quiet_NaN();        // m
};

struct Epoch {
  Time t = no_time;
  int line = 0;
  int event = 0;                                                   // 0: nothing; 1: power failure before it
  double clock_offset = std::numeric_limits<double>::quiet_NaN();  // s, as the file gives it
  double clock_jump = 0;  // m, of the receiver's clock since the epoch before, found from code and phase
  std::vector<Observation> satellites;
};

/// Epochs in order of time. Times count from the begin of GPS week `origin_week`.
std::vector<Epoch> read_observations(const std::string& path, int origin_week, const Signals& signals, Faults& faults);

}  // namespace binnacle::rinex
