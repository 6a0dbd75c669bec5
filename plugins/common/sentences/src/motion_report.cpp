// SPDX-License-Identifier: Apache-2.0
// NMEA 0183 version 4.11.
#include "sentences/motion_report.hpp"

#include <cmath>
#include <numbers>

namespace binnacle::sentences {

namespace {

constexpr double knot = 1852.0 / 3600.0;  // [m/s]
constexpr double nan = Motion::unknown;

}  // namespace

void MotionReport::append(std::string& text, Type type, const Motion& motion) const {
  SentenceWriter out(text, talker_, type_names[static_cast<std::size_t>(type)]);
  const bool is_valid = std::isfinite(motion.lat) && std::isfinite(motion.lon) && motion.is_accurate;
  const double speed = std::hypot(motion.vn, motion.ve), course = speed > 0 ? std::atan2(motion.ve, motion.vn) : nan;
  const auto position = [&] {
    out.latitude(is_valid ? motion.lat : nan);
    out.longitude(is_valid ? std::remainder(motion.lon, 2 * std::numbers::pi) : nan);
  };
  const auto separation = [&](double value) {
    out.number(is_valid && std::isfinite(motion.height) ? value : nan, 3);
    out.letter('M');
  };
  switch (type) {
    case Type::gga:
      out.time_of_day(motion.utc.of_day);
      position();
      out.letter(is_valid ? quality_.gga : '0');
      out.empty();  // satellites in use
      out.empty();  // HDOP
      separation(motion.height - geoid_separation_);
      separation(geoid_separation_);
      out.empty();  // age of corrections
      out.empty();  // their station
      break;
    case Type::rmc:
      out.time_of_day(motion.utc.of_day);
      out.letter(is_valid ? 'A' : 'V');
      position();
      out.number(speed / knot, 3);
      out.bearing(course, 3);
      out.date(motion.utc.day);
      out.empty();  // magnetic variation
      out.empty();
      out.letter(is_valid ? quality_.mode : 'N');
      break;
    case Type::vtg:
      out.bearing(course, 3);
      out.letter('T');
      out.empty();  // magnetic course
      out.letter('M');
      out.number(speed / knot, 3);
      out.letter('N');
      out.number(speed * 3.6, 3);
      out.letter('K');
      out.letter(std::isfinite(speed) ? quality_.mode : 'N');
      break;
    case Type::hdt:
      out.bearing(motion.yaw, 3);
      out.letter('T');
      break;
  }
  out.end();
}

}  // namespace binnacle::sentences
