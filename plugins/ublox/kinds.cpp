// SPDX-License-Identifier: Apache-2.0
// u-blox M8 receiver description including protocol specification (UBX-13003221), ZED-F9P interface description
// (UBX-18010854), ZED-F9R interface description (UBX-19056845): the places and scales of the fields.
#include "kinds.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace binnacle::ublox {

namespace {

constexpr std::uint32_t no_accuracy = 0xFFFFFFFF;

using field::level;
using field::rate;

constexpr std::array<std::pair<int, const char*>, 11> names{{{nav_posllh, "NAV-POSLLH"},
                                                             {nav_status, "NAV-STATUS"},
                                                             {nav_pvt, "NAV-PVT"},
                                                             {nav_velned, "NAV-VELNED"},
                                                             {nav_hpposllh, "NAV-HPPOSLLH"},
                                                             {nav_relposned, "NAV-RELPOSNED"},
                                                             {rxm_sfrbx, "RXM-SFRBX"},
                                                             {rxm_rawx, "RXM-RAWX"},
                                                             {esf_meas, "ESF-MEAS"},
                                                             {esf_raw, "ESF-RAW"},
                                                             {esf_ins, "ESF-INS"}}};

std::vector<FieldSpec> position_fields() {
  return {level("lat", "rad").about("geodetic latitude"),
          level("lon", "rad").about("longitude, east positive"),
          level("height", "m").about("height above the ellipsoid"),
          level("height_msl", "m").about("above the receiver's mean sea level"),
          level("position_sd_n", "m").about("hAcc"),
          level("position_sd_e", "m").about("hAcc"),
          level("position_sd_d", "m").about("vAcc")};
}

std::vector<FieldSpec> velocity_fields() {
  return {level("vn", "m/s").about("over ground, north"),
          level("ve", "m/s").about("east"),
          level("vd", "m/s").about("down"),
          level("speed", "m/s").about("over ground"),
          level("course", "rad").about("over ground, from true north"),
          level("velocity_sd_n", "m/s").about("sAcc"),
          level("velocity_sd_e", "m/s").about("sAcc"),
          level("velocity_sd_d", "m/s").about("sAcc"),
          level("course_sd", "rad")};
}

std::vector<FieldSpec> joined(std::vector<FieldSpec> all, std::vector<FieldSpec> more) {
  for (FieldSpec& each : more) all.push_back(std::move(each));
  return all;
}

std::vector<FieldSpec> pvt_fields() {
  return joined(joined(position_fields(), velocity_fields()),
                {level("yaw", "rad").about("of the vehicle, where the receiver gives it"),
                 level("declination", "rad").about("magnetic"), level("declination_sd", "rad"),
                 level("time_sd", "s").about("tAcc"),
                 level("fix_type", "1").about("1 dead reckoning, 2 2D, 3 3D, 4 GNSS and dead reckoning"),
                 level("carrier", "1").about("of the carrier phase: 0 none, 1 float, 2 fixed"),
                 level("differential", "1").about("1: corrections were applied"),
                 level("satellites", "1").about("used"), level("pdop", "1")});
}

std::vector<FieldSpec> relative_fields() {
  return {level("relative_n", "m").about("from the reference antenna to this one, north"),
          level("relative_e", "m").about("east"),
          level("relative_d", "m").about("down"),
          level("relative_sd_n", "m"),
          level("relative_sd_e", "m"),
          level("relative_sd_d", "m"),
          level("length", "m"),
          level("length_sd", "m"),
          level("yaw", "rad").about("of the baseline, from true north"),
          level("yaw_sd", "rad"),
          level("carrier", "1").about("of the carrier phase: 0 none, 1 float, 2 fixed"),
          level("differential", "1"),
          level("station", "1").about("of the reference")};
}

std::vector<FieldSpec> ins_fields() {
  return {level("wx", "rad/s").about("vehicle axes, corrected"),         level("wy", "rad/s"), level("wz", "rad/s"),
          level("ax", "m/s^2").about("acceleration, gravity taken off"), level("ay", "m/s^2"), level("az", "m/s^2")};
}

std::vector<FieldSpec> imu_fields() {
  return {rate("wx", "rad/s").about("the receiver's sensor axes"),
          rate("wy", "rad/s"),
          rate("wz", "rad/s"),
          rate("fx", "m/s^2").about("specific force"),
          rate("fy", "m/s^2"),
          rate("fz", "m/s^2"),
          level("temperature", "K").about("of the gyro")};
}

std::vector<FieldSpec> wheel_fields() {
  return {level("front_left", "1").about("ticks, falling where it turns backward"),
          level("front_right", "1"),
          level("rear_left", "1"),
          level("rear_right", "1"),
          level("single", "1").about("ticks of the one odometer"),
          level("speed", "m/s")};
}

/// SI as it is scaled; the largest number stands for "not known".
double accuracy(std::uint32_t value, double scale) { return value == no_accuracy ? nan : value * scale; }

void add_position(const Payload& p, std::size_t lon, std::size_t accuracies, std::vector<double>& v) {
  v.insert(v.end(),
           {p.i4(lon + 4) * 1e-7 * degree, p.i4(lon) * 1e-7 * degree, p.i4(lon + 8) * 1e-3, p.i4(lon + 12) * 1e-3,
            accuracy(p.u4(accuracies), 1e-3), accuracy(p.u4(accuracies), 1e-3), accuracy(p.u4(accuracies + 4), 1e-3)});
}

Reading read_pvt(const Payload& p) {
  const int fix = p.u1(20);
  const bool has_fix = p.bit(21, 0) && fix >= 1 && fix <= 4;
  if (!has_fix) return {{}, "without a fix (gnssFixOK, fixType)"};
  if (p.size() >= 92 && p.bit(78, 0)) return {{}, "of which the position is invalid (invalidLlh)"};
  std::vector<double> v;
  add_position(p, 24, 40, v);
  const double speed_sd = accuracy(p.u4(68), 1e-3);
  v.insert(v.end(), {p.i4(48) * 1e-3, p.i4(52) * 1e-3, p.i4(56) * 1e-3, p.i4(60) * 1e-3, p.i4(64) * 1e-5 * degree,
                     speed_sd, speed_sd, speed_sd, accuracy(p.u4(72), 1e-5 * degree)});
  const bool is_long = p.size() >= 92;
  const bool has_yaw = is_long && p.bit(21, 5), has_declination = is_long && p.bit(11, 3);
  v.insert(v.end(), {has_yaw ? p.i4(84) * 1e-5 * degree : nan, has_declination ? p.i2(88) * 1e-2 * degree : nan,
                     has_declination ? p.u2(90) * 1e-2 * degree : nan, accuracy(p.u4(12), 1e-9),
                     static_cast<double>(fix), static_cast<double>(p.u1(21) >> 6), static_cast<double>(p.bit(21, 1)),
                     static_cast<double>(p.u1(23)), p.u2(76) * 0.01});
  return {std::move(v)};
}

Reading read_posllh(const Payload& p) {
  Reading reading;
  add_position(p, 4, 20, reading.values);
  if (p.u4(20) == no_accuracy) reading.refusal = "without a fix (its accuracy is unknown)";
  return reading;
}

Reading read_hpposllh(const Payload& p) {
  if (p.bit(3, 0)) return {{}, "of which the position is invalid (invalidLlh)"};
  if (p.u4(28) == no_accuracy) return {{}, "without a fix (its accuracy is unknown)"};
  const double sd = p.u4(28) * 1e-4;
  // Degrees are put together as integers, 1e-9 deg: as exact as they come.
  const auto angle = [&](std::size_t coarse, std::size_t fine) {
    return static_cast<double>(p.i4(coarse) * std::int64_t{100} + p.i1(fine)) * 1e-9 * degree;
  };
  const auto height = [&](std::size_t coarse, std::size_t fine) {
    return static_cast<double>(p.i4(coarse) * std::int64_t{10} + p.i1(fine)) * 1e-4;
  };
  return {{angle(12, 25), angle(8, 24), height(16, 26), height(20, 27), sd, sd, accuracy(p.u4(32), 1e-4)}};
}

Reading read_velned(const Payload& p) {
  if (p.u4(28) == no_accuracy) return {{}, "without a fix (its accuracy is unknown)"};
  const double sd = p.u4(28) * 1e-2;
  return {{p.i4(4) * 1e-2, p.i4(8) * 1e-2, p.i4(12) * 1e-2, p.u4(20) * 1e-2, p.i4(24) * 1e-5 * degree, sd, sd, sd,
           accuracy(p.u4(32), 1e-5 * degree)}};
}

/// Version 0 has no length, no heading and their places are others.
Reading read_relposned(const Payload& p) {
  const bool is_first = p.u1(0) == 0;
  const std::size_t flags = is_first ? 36 : 60, vector = 8, fine = is_first ? 20 : 32, sd = is_first ? 24 : 36;
  const std::uint32_t f = p.u4(flags);
  const auto flag = [&](int which) { return (f >> which & 1) != 0; };
  if (!flag(0) || !flag(2)) return {{}, "without a solution (gnssFixOK, relPosValid)"};
  if (!is_first && flag(9)) return {{}, "of which the vector is normalized (relPosNormalized)"};
  std::vector<double> v;
  for (std::size_t i = 0; i < 3; ++i) v.push_back(p.i4(vector + 4 * i) * 1e-2 + p.i1(fine + i) * 1e-4);
  for (std::size_t i = 0; i < 3; ++i) v.push_back(p.u4(sd + 4 * i) * 1e-4);
  if (is_first) {
    v.insert(v.end(), {nan, nan, nan, nan});
  } else {
    v.insert(v.end(), {p.i4(20) * 1e-2 + p.i1(35) * 1e-4, p.u4(48) * 1e-4});
    const bool has_heading = flag(8);
    v.insert(v.end(), {has_heading ? p.i4(24) * 1e-5 * degree : nan, has_heading ? p.u4(52) * 1e-5 * degree : nan});
  }
  v.insert(v.end(), {static_cast<double>(f >> 3 & 3), static_cast<double>(flag(1)), static_cast<double>(p.u2(2))});
  return {std::move(v)};
}

Reading read_ins(const Payload& p) {
  const std::uint32_t f = p.u4(0);
  Reading reading;
  for (int i = 0; i < 3; ++i)
    reading.values.push_back((f >> (8 + i) & 1) ? p.i4(12 + 4 * static_cast<std::size_t>(i)) * 1e-3 * degree : nan);
  for (int i = 0; i < 3; ++i)
    reading.values.push_back((f >> (11 + i) & 1) ? p.i4(24 + 4 * static_cast<std::size_t>(i)) * 1e-2 : nan);
  if ((f >> 8 & 0x3F) == 0) reading.refusal = "of which nothing is valid";
  return reading;
}

}  // namespace

std::string message_name(int type) {
  for (const auto& [known, name] : names)
    if (known == type) return name;
  char text[32];
  std::snprintf(text, sizeof text, "%02X-%02X", type >> 8, type & 0xFF);
  return text;
}

std::vector<std::string> message_names() {
  std::vector<std::string> all;
  for (const auto& [type, name] : names)
    if (type != nav_status) all.emplace_back(name);
  return all;
}

int message_type(std::string_view name) {
  for (const auto& [type, known] : names)
    if (known == name) return type;
  return -1;
}

std::vector<ValueKind> value_kinds() {
  return {{Kind::pvt, nav_pvt, "", pvt_fields()},
          {Kind::posllh, nav_posllh, "posllh", position_fields()},
          {Kind::velned, nav_velned, "velned", velocity_fields()},
          {Kind::hpposllh, nav_hpposllh, "hpposllh", position_fields()},
          {Kind::relposned, nav_relposned, "relposned", relative_fields()},
          {Kind::ins, esf_ins, "ins", ins_fields()},
          {Kind::imu, esf_meas, "imu", imu_fields()},
          {Kind::wheels, esf_meas, "wheels", wheel_fields()},
          {Kind::imu_raw, esf_raw, "imu_raw", imu_fields()}};
}

std::optional<Reading> read_solution(Kind kind, const Payload& p) {
  switch (kind) {
    case Kind::pvt: return p.size() == 92 || p.size() == 84 ? std::optional(read_pvt(p)) : std::nullopt;
    case Kind::posllh: return p.size() == 28 ? std::optional(read_posllh(p)) : std::nullopt;
    case Kind::velned: return p.size() == 36 ? std::optional(read_velned(p)) : std::nullopt;
    case Kind::hpposllh: return p.size() == 36 && p.u1(0) == 0 ? std::optional(read_hpposllh(p)) : std::nullopt;
    case Kind::relposned: {
      const bool is_known = (p.size() == 40 && p.u1(0) == 0) || (p.size() == 64 && p.u1(0) == 1);
      return is_known ? std::optional(read_relposned(p)) : std::nullopt;
    }
    case Kind::ins: return p.size() == 36 && p.u1(0) == 1 ? std::optional(read_ins(p)) : std::nullopt;
    default: return std::nullopt;
  }
}

}  // namespace binnacle::ublox
