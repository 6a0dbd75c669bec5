// SPDX-License-Identifier: Apache-2.0
// A position, velocity and heading as GGA, RMC, VTG and HDT.
#pragma once

#include <array>
#include <limits>
#include <string>

#include "sentences/sentence_writer.hpp"

namespace binnacle::sentences {

/// In the order in which they are written unless somebody chooses another.
enum class Type { gga, rmc, vtg, hdt };
inline constexpr std::array<const char*, 4> type_names{"GGA", "RMC", "VTG", "HDT"};

/// What GGA says of a valid position, and the mode of RMC and VTG.
struct Quality {
  const char* name;
  char gga;
  char mode;
};
inline constexpr std::array<Quality, 7> qualities{{{"autonomous", '1', 'A'},
                                                   {"differential", '2', 'D'},
                                                   {"rtk", '4', 'R'},
                                                   {"float", '5', 'F'},
                                                   {"estimated", '6', 'E'},
                                                   {"manual", '7', 'M'},
                                                   {"simulator", '8', 'S'}}};
inline constexpr std::size_t estimated = 4;  // in qualities

/// What is not finite is an empty field.
struct Motion {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  Utc utc;
  double lat = unknown, lon = unknown;  // geodetic [rad]; lon of any turn
  double height = unknown;              // above the ellipsoid [m]
  double vn = unknown, ve = unknown;    // over ground [m/s]
  double yaw = unknown;                 // from true north to east [rad]
  bool is_accurate = true;              // else the position counts as none
};

/// One talker's way to write it.
class MotionReport {
 public:
  /// `geoid_separation`: height of the geoid above the ellipsoid [m]; NaN: not known, and GGA has no height.
  MotionReport(std::string talker, const Quality& quality, double geoid_separation)
      : talker_(std::move(talker)), quality_(quality), geoid_separation_(geoid_separation) {}

  /// The time, rounded to a millisecond, as that of the sentences.
  static Time rounded(Time t) { return t + 500'000; }
  void append(std::string& text, Type type, const Motion& motion) const;

 private:
  std::string talker_;
  Quality quality_;
  double geoid_separation_;
};

}  // namespace binnacle::sentences
