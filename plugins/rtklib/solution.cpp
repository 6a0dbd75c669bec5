// SPDX-License-Identifier: Apache-2.0
#include "solution.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "binnacle/geodesy.hpp"

namespace binnacle::rtklib {

namespace {

using Words = std::vector<std::string_view>;
using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

double needed(std::string_view word) {
  const auto value = number(word);
  if (!value) throw BadLine{"'" + std::string(word.substr(0, 30)) + "' is not a number"};
  return *value;
}

/// Decimal digits of which none is lost: "408640.0005" [ns].
Time time_of_seconds(std::string_view text) {
  const auto point = std::min(text.find('.'), text.size());
  std::int64_t whole = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + point, whole);
  if (error != std::errc() || rest != text.data() + point || whole < 0 || whole > 604800)
    throw BadLine{"'" + std::string(text.substr(0, 30)) + "' is not a time in seconds"};
  Time fraction = 0, place = nanoseconds_per_second / 10;
  for (std::size_t i = point + 1; i < text.size(); ++i, place /= 10) {
    if (text[i] < '0' || text[i] > '9')
      throw BadLine{"'" + std::string(text.substr(0, 30)) + "' is not a time in seconds"};
    fraction += (text[i] - '0') * place;
  }
  return whole * nanoseconds_per_second + fraction;
}

/// "2025/08/28".
civil_time::Day day_of(std::string_view text) {
  std::string iso(text);
  for (char& c : iso)
    if (c == '/') c = '-';
  const auto day = civil_time::parse_day(iso);
  if (!day || text.size() != 10 || text[4] != '/' || text[7] != '/')
    throw BadLine{"'" + std::string(text.substr(0, 30)) + "' is not a date"};
  return *day;
}

/// "17:30:40.000".
Time time_of_day(std::string_view text) {
  if (text.size() < 8 || text[2] != ':' || text[5] != ':')
    throw BadLine{"'" + std::string(text.substr(0, 30)) + "' is not a time of day"};
  const Time h = time_of_seconds(text.substr(0, 2)), m = time_of_seconds(text.substr(3, 2)),
             s = time_of_seconds(text.substr(6));
  constexpr Time one = nanoseconds_per_second;
  if (h > 23 * one || m > 59 * one || s >= 61 * one)
    throw BadLine{"'" + std::string(text.substr(0, 30)) + "' is not a time of day"};
  return h * 3600 + m * 60 + s;
}

/// Either form, in any of the three systems. RTKLIB counts weeks of UTC and JST from 1980-01-06 too.
Time time_of(std::string_view first, std::string_view second, TimeSystem system, const civil_time::UtcClock& clock) {
  civil_time::Utc label;
  if (first.find('/') != first.npos) {
    label = {day_of(first), time_of_day(second)};
  } else {
    int week = 0;
    const auto [rest, error] = std::from_chars(first.data(), first.data() + first.size(), week);
    if (error != std::errc() || rest != first.data() + first.size() || week < 0 || week > 8900)
      throw BadLine{"'" + std::string(first.substr(0, 30)) + "' is neither a date nor a week"};
    const Time of_week = time_of_seconds(second);
    label.day = civil_time::gps_epoch + std::chrono::days(7 * week + of_week / civil_time::day_length);
    label.of_day = of_week % civil_time::day_length;
  }
  if (system == TimeSystem::gpst)
    return clock.time_of_gps(civil_time::begin_of(label.day) + label.of_day -
                             civil_time::begin_of(civil_time::gps_epoch));
  if (system == TimeSystem::jst) {
    label.of_day -= 9 * 3600 * nanoseconds_per_second;
    if (label.of_day < 0) {
      label.of_day += civil_time::day_length;
      label.day -= std::chrono::days(1);
    }
  }
  return clock.time(label);
}

/// Of 11 22 33 12 23 31, of which the cross terms are the root of the covariance's magnitude with its sign.
Matrix3 covariance_of(const Words& rest, const std::array<int, sd_count>& places) {
  std::array<double, sd_count> s;
  for (std::size_t i = 0; i < sd_count; ++i) s[i] = needed(rest[static_cast<std::size_t>(places[i])]);
  for (std::size_t i = 0; i < 3; ++i)
    if (s[i] < 0) throw BadLine{"a standard deviation is negative"};
  const auto squared = [](double x) { return x < 0 ? -x * x : x * x; };
  Matrix3 P;
  P << squared(s[0]), squared(s[3]), squared(s[5]), squared(s[3]), squared(s[1]), squared(s[4]), squared(s[5]),
      squared(s[4]), squared(s[2]);
  return P;
}

/// From the axes of the columns to north, east, down.
Matrix3 axes_of(Coordinates coordinates, const Vector3& lla) {
  if (coordinates == Coordinates::ecef) return geodesy::C_en(lla[0], lla[1]).transpose();
  Matrix3 C = Matrix3::Zero();
  const bool is_baseline = coordinates == Coordinates::baseline;  // east, north, up; else north, east, up
  C(0, is_baseline ? 1 : 0) = 1;
  C(1, is_baseline ? 0 : 1) = 1;
  C(2, 2) = -1;
  return C;
}

/// `at`: the word behind time and position.
void read_position(const Words& w, const Layout& layout, const Place& place, Solution& s, std::size_t& at) {
  if (layout.coordinates == Coordinates::ecef || layout.coordinates == Coordinates::baseline) {
    const Vector3 v(needed(w[2]), needed(w[3]), needed(w[4]));
    at = 5;
    if (layout.coordinates == Coordinates::ecef) {
      if (v.norm() < 6e6 || v.norm() > 5e7) throw BadLine{"the position is not near the earth"};
      s.lla = geodesy::lla_from_ecef(v);
      return;
    }
    s.relative = {v[1], v[0], -v[2]};
    const auto& reference = place.reference ? place.reference : layout.reference;
    if (!reference) return;
    const Vector3 r = geodesy::ecef_from_lla(*reference);
    s.lla = geodesy::lla_from_ecef(r + geodesy::C_en((*reference)[0], (*reference)[1]) * s.relative);
    return;
  }
  double height = 0;
  if (layout.coordinates == Coordinates::dms) {
    const auto lat = angle_of_dms(w[2], w[3], w[4]), lon = angle_of_dms(w[5], w[6], w[7]);
    if (!lat || !lon) throw BadLine{"a coordinate is not in degrees, minutes and seconds"};
    s.lla = {*lat, *lon, 0};
    height = needed(w[8]);
    at = 9;
  } else {
    s.lla = {needed(w[2]) * degree, needed(w[3]) * degree, 0};
    height = needed(w[4]);
    at = 5;
  }
  if (std::abs(s.lla[0]) > 90 * degree || std::abs(s.lla[1]) > 360 * degree)
    throw BadLine{"a coordinate is beyond its range"};
  s.lla[2] = height + (layout.is_height_above_sea ? place.geoid_separation : 0);
}

}  // namespace

Solution read_solution(std::string_view line, const Layout& layout, const Place& place,
                       const civil_time::UtcClock& clock) {
  const Words w = words(line);
  const std::size_t before = layout.coordinates == Coordinates::dms ? 9 : 5;
  const std::size_t expected = before + static_cast<std::size_t>(layout.columns.count);
  if (w.size() != expected)
    throw BadLine{"it has " + std::to_string(w.size()) + " words instead of " + std::to_string(expected)};
  Solution s;
  s.t = time_of(w[0], w[1], layout.time, clock);
  std::size_t at = 0;
  read_position(w, layout, place, s, at);
  const Words rest(w.begin() + static_cast<std::ptrdiff_t>(at), w.end());
  const Columns& c = layout.columns;
  const auto value = [&](int column) {
    return column < 0 ? Solution::nan : needed(rest[static_cast<std::size_t>(column)]);
  };
  s.quality = value(c.quality);
  s.satellites = value(c.satellites);
  s.age = value(c.age);
  s.ratio = value(c.ratio);
  const Matrix3 C = axes_of(layout.coordinates, s.lla);
  if (c.has_position_sd()) s.position_covariance = C * covariance_of(rest, c.position_sd) * C.transpose();
  if (c.has_velocity()) s.velocity = C * Vector3(value(c.velocity[0]), value(c.velocity[1]), value(c.velocity[2]));
  if (c.has_velocity_sd()) s.velocity_covariance = C * covariance_of(rest, c.velocity_sd) * C.transpose();
  return s;
}

}  // namespace binnacle::rtklib
