// SPDX-License-Identifier: Apache-2.0
// Broadcast messages of a RINEX navigation file.
#pragma once

#include <optional>
#include <vector>

#include "faults.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::rinex {

struct Message {
  gnss::Ephemeris ephemeris;
  Time toe = no_time;
  Time uploaded = no_time;  // transmission of the message; where the file gives none, two hours before toe
  bool is_healthy = false;
  int line = 0;
};

struct Navigation {
  std::vector<Message> messages;  // in the order of the file
  std::optional<gnss::Klobuchar> klobuchar;
};

/// Messages of GPS (LNAV) and Galileo (I/NAV); those of other systems are passed over.
/// Times count from the begin of GPS week `origin_week`.
Navigation read_navigation(const std::string& path, int origin_week, Faults& faults);

}  // namespace binnacle::rinex
