// SPDX-License-Identifier: Apache-2.0
// dataformat.txt of the oxts folders of A. Geiger, P. Lenz, C. Stiller, R. Urtasun, "Vision meets robotics: the KITTI
// dataset", IJRR 32 (2013): 30 numbers, their units, axes and signs.
#include "oxts_record.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "civil_time/iso8601.hpp"

namespace binnacle::kitti {

namespace {

constexpr double degree = std::numbers::pi / 180;
enum Column {
  lat,
  lon,
  alt,
  roll,
  pitch,
  yaw,
  vn,
  ve,
  vf,
  vl,
  vu,
  ax,
  ay,
  az,
  af,
  al,
  au,
  wx,
  wy,
  wz,
  wf,
  wl,
  wu,
  position_accuracy,
  velocity_accuracy,
  navigation_status,
  column_count = 30
};

/// The numbers of a line; how many there are, −1: a word is none.
int read_numbers(std::string_view line, std::array<double, column_count>& values) {
  int count = 0;
  constexpr std::string_view blank = " \t\r";
  for (;;) {
    const auto begin = line.find_first_not_of(blank);
    if (begin == line.npos) return count;
    line.remove_prefix(begin);
    const auto end = std::min(line.find_first_of(blank), line.size());
    double value = 0;
    const auto [rest, error] = std::from_chars(line.data(), line.data() + end, value);
    if (error != std::errc() || rest != line.data() + end || !std::isfinite(value)) return -1;
    if (count < column_count) values[static_cast<std::size_t>(count)] = value;
    ++count;
    line.remove_prefix(end);
  }
}

}  // namespace

std::string read_record(std::string_view line, OxtsRecord& record) {
  std::array<double, column_count> v{};
  const int count = read_numbers(line, v);
  if (count < 0) return "a word is not a number";
  if (count != column_count) return "it has " + std::to_string(count) + " numbers instead of 30";
  if (std::abs(v[lat]) > 90 || std::abs(v[lon]) > 180) return "a coordinate is beyond its range";
  if (v[position_accuracy] < 0 || v[velocity_accuracy] < 0) return "an accuracy is negative";
  record.lla = {v[lat] * degree, v[lon] * degree, v[alt]};
  record.v_n = {v[vn], v[ve], -v[vu]};
  // Roll: left side up. Pitch: front down. Yaw: from east, counterclockwise.
  record.attitude = {v[roll], -v[pitch], std::remainder(std::numbers::pi / 2 - v[yaw], 2 * std::numbers::pi)};
  record.w_b = {v[wx], -v[wy], -v[wz]};
  record.f_b = {v[ax], -v[ay], -v[az]};
  record.position_sd = v[position_accuracy];
  record.velocity_sd = v[velocity_accuracy];
  for (std::size_t i = 0; i < record.state.size(); ++i) record.state[i] = v[navigation_status + i];
  return {};
}

std::optional<civil_time::Utc> read_stamp(std::string_view line) {
  while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.remove_suffix(1);
  return civil_time::parse_utc(line);
}

}  // namespace binnacle::kitti
