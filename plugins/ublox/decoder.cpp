// SPDX-License-Identifier: Apache-2.0
#include "decoder.hpp"

#include <algorithm>
#include <cmath>

#include "gnss/orbit.hpp"

namespace binnacle::ublox {

namespace {

constexpr Time second = nanoseconds_per_second;
using civil_time::week_length;
constexpr Time most_apart = 60 * second;           // UTC and GPS time, and then some
constexpr int last_year = 2150, last_week = 8900;  // beyond them nanoseconds are too many
constexpr double wavelength = gnss::speed_of_light / gnss::l1_frequency;

/// Class and RINEX code of a signal on the first frequency; empty: another one.
const char* code_of(int system, int signal) {
  if (system == 0) return signal == 0 ? "1C" : "";
  if (system == 2) return signal == 0 ? "1C" : signal == 1 ? "1B" : "";
  return "";
}

/// a − b brought to within half a week.
Time within_half_a_week(Time difference) {
  difference %= week_length;
  if (difference > week_length / 2) difference -= week_length;
  if (difference < -week_length / 2) difference += week_length;
  return difference;
}

}  // namespace

std::optional<Time> Decoder::instant_of(const Frame& frame) const {
  const Payload p(frame.payload);
  if (frame.type() == nav_pvt && (p.size() == 92 || p.size() == 84)) return pvt_instant(p);
  if (frame.type() == rxm_rawx && p.size() >= 16) return rawx_instant(p);
  return {};
}

/// The date gives the week, iTOW the time in it. Nothing where the receiver does not vouch for them, or they disagree.
std::optional<Time> Decoder::pvt_instant(const Payload& p) const {
  const bool is_valid = p.bit(11, 0) && p.bit(11, 1);
  const std::chrono::year_month_day date{std::chrono::year(p.u2(4)), std::chrono::month(p.u1(6)),
                                         std::chrono::day(p.u1(7))};
  if (!is_valid || !date.ok() || p.u2(4) < 1980 || p.u2(4) > last_year || p.u1(8) > 23 || p.u1(9) > 59 ||
      p.u1(10) > 60 || p.u4(0) >= 604800000)
    return {};
  const Time of_day = (p.u1(8) * 3600 + p.u1(9) * 60 + p.u1(10)) * second + p.i4(16);
  const Time near = options_.clock.gps_of({civil_time::Day(date), of_day});
  const Time apart = within_half_a_week(p.u4(0) * Time{1'000'000} - near % week_length);
  if (near < 0 || std::abs(apart) > most_apart) return {};
  return near + apart;
}

std::optional<Time> Decoder::rawx_instant(const Payload& p) const {
  const double tow = p.r8(0);
  if (p.u2(8) == 0 || p.u2(8) > last_week || !(tow >= 0 && tow < 604800)) return {};
  return p.u2(8) * week_length + nanoseconds(tow);
}

Time Decoder::time_of_week(std::uint32_t milliseconds) const {
  if (now_ == no_time || milliseconds >= 604800000) return no_time;
  return now_ + within_half_a_week(milliseconds * Time{1'000'000} - now_ % week_length);
}

void Decoder::see_epoch(Time gps) {
  now_ = gps;
  sensors_.clock().see_epoch(gps);
  raw_sensors_.clock().see_epoch(gps);
}

void Decoder::take(const Frame& frame, std::vector<Item>& items, Complaints& complaints) {
  const int type = frame.type();
  if (const auto instant = instant_of(frame)) now_ = *instant;
  if (type == nav_status && frame.payload.size() == 16) {
    has_fix_ = Payload(frame.payload).bit(5, 0);
    return;
  }
  if (!options_.wanted[static_cast<std::size_t>(type)]) {
    ++passed_over_[type];
    return;
  }
  switch (type) {
    case rxm_rawx: return take_rawx(frame, items, complaints);
    case rxm_sfrbx: return take_subframe(frame, items, complaints);
    case esf_meas: return take_meas(frame, items, complaints);
    case esf_raw: return take_raw(frame, items, complaints);
    default: break;
  }
  for (const ValueKind& kind : kinds_)
    if (kind.type == type) return take_solution(kind, frame, items, complaints);
}

void Decoder::take_solution(const ValueKind& kind, const Frame& frame, std::vector<Item>& items,
                            Complaints& complaints) {
  const Payload p(frame.payload);
  auto reading = read_solution(kind.kind, p);
  const std::string name = message_name(kind.type);
  if (!reading) return complaints.damage("B062", name + " of unknown length or version", frame.at);
  const std::size_t of_week = kind.kind == Kind::relposned || kind.kind == Kind::hpposllh ? 4
                              : kind.kind == Kind::ins                                    ? 8
                                                                                          : 0;
  const bool is_pvt = kind.kind == Kind::pvt;
  const auto instant = is_pvt ? pvt_instant(p) : std::nullopt;
  const Time t = instant ? *instant : time_of_week(p.u4(of_week));
  if (t == no_time) return complaints.note("B065", name + " before the receiver reported the week", frame.at);
  if (kind.kind != Kind::ins) see_epoch(t);
  if (is_pvt) {
    has_fix_ = !reading->refusal;
    if (instant && p.bit(11, 2)) {
      const Time utc = Time{civil_time::begin_of(std::chrono::year(p.u2(4)) / p.u1(6) / p.u1(7))} +
                       (p.u1(8) * 3600 + p.u1(9) * 60 + p.u1(10)) * second + p.i4(16);
      leap_ = static_cast<int>(std::lround(seconds(t + civil_time::begin_of(civil_time::gps_epoch) - utc)));
    }
  }
  const bool is_fix = kind.kind == Kind::posllh || kind.kind == Kind::velned || kind.kind == Kind::hpposllh;
  if (is_fix && !has_fix_ && !reading->refusal) reading->refusal = "without a fix (NAV-PVT or NAV-STATUS says so)";
  if (reading->refusal) return complaints.note("B065", name + " " + reading->refusal, frame.at);
  Item item;
  item.kind = kind.kind;
  item.t = t;
  item.at = frame.at;
  item.values = std::move(reading->values);
  items.push_back(std::move(item));
}

void Decoder::take_rawx(const Frame& frame, std::vector<Item>& items, Complaints& complaints) {
  const Payload p(frame.payload);
  if (p.size() < 16 || p.size() != 16u + 32u * p.u1(11))
    return complaints.damage("B062", "RXM-RAWX of unknown length", frame.at);
  const auto t = rawx_instant(p);
  if (!t) return complaints.note("B065", "RXM-RAWX before the receiver knew its time", frame.at);
  see_epoch(*t);
  if (p.bit(12, 0)) leap_ = p.i1(10);
  Item item;
  item.kind = Kind::obs;
  item.t = item.epoch.t = *t;
  item.at = frame.at;
  for (std::size_t at = 16; at < p.size(); at += 32) {
    const int system = p.u1(at + 20), signal = p.u1(13) == 0 ? 0 : p.u1(at + 22), number = p.u1(at + 21);
    const std::string code = code_of(system, signal);
    const auto constellation = system == 2 ? gnss::Constellation::galileo : gnss::Constellation::gps;
    if (code.empty() || options_.signals.of(constellation) != code) continue;
    if (number < 1 || number > (system == 2 ? 36 : 32)) {
      complaints.damage("B062", "observations of RXM-RAWX that are of no satellite", frame.at);
      continue;
    }
    gnss::Observation o;
    o.satellite = gnss::satellite_key(constellation, number);
    o.pseudorange = p.r8(at);
    if (!p.bit(at + 30, 0) || !std::isfinite(o.pseudorange) || o.pseudorange <= 0) {
      complaints.note("B065", "observations of RXM-RAWX without a valid pseudorange", frame.at);
      continue;
    }
    const bool is_twice = std::any_of(item.epoch.satellites.begin(), item.epoch.satellites.end(),
                                      [&](const gnss::Observation& other) { return other.satellite == o.satellite; });
    if (is_twice) {
      complaints.damage("B062", "observations of RXM-RAWX that appear twice", frame.at);
      continue;
    }
    const double doppler = p.r4(at + 16), phase = p.r8(at + 8);
    if (std::isfinite(doppler)) o.range_rate = -wavelength * doppler;  // coming nearer: a positive shift
    if (p.bit(at + 30, 1) && std::isfinite(phase) && phase != 0) o.phase = phase * wavelength;
    o.cn0 = p.u1(at + 26);
    item.epoch.satellites.push_back(o);
  }
  items.push_back(std::move(item));
}

void Decoder::take_subframe(const Frame& frame, std::vector<Item>& items, Complaints& complaints) {
  if (now_ == no_time) return complaints.note("B065", "RXM-SFRBX before the receiver reported the week", frame.at);
  Item item;
  item.broadcast = broadcasts_.take(Payload(frame.payload), now_);
  if (item.broadcast.fault) complaints.damage("B062", std::string("RXM-SFRBX: ") + item.broadcast.fault, frame.at);
  if (item.broadcast.ignored) complaints.note("B065", std::string("RXM-SFRBX ") + item.broadcast.ignored, frame.at);
  if (!item.broadcast.message && !item.broadcast.klobuchar) return;
  item.kind = Kind::subframe;
  item.t = now_;
  item.at = frame.at;
  items.push_back(std::move(item));
}

void Decoder::take_meas(const Frame& frame, std::vector<Item>& items, Complaints& complaints) {
  const Payload p(frame.payload);
  const std::size_t count = p.size() < 8 ? 0 : p.u2(4) >> 11;
  const bool has_calibrated = p.size() >= 8 && p.bit(4, 3);
  if (p.size() < 8 || p.size() != 8 + 4 * count + (has_calibrated ? 4 : 0))
    return complaints.damage("B062", "ESF-MEAS of unknown length", frame.at);
  std::vector<SensorSample> complete;
  for (std::size_t i = 0; i < count; ++i)
    if (!sensors_.add(p.u4(0), p.u4(8 + 4 * i), complete))
      complaints.note("B065", "data of ESF-MEAS of a type that is not read", frame.at);
  add_sensors(complete, Kind::imu, frame.at, items, &complaints);
}

void Decoder::take_raw(const Frame& frame, std::vector<Item>& items, Complaints& complaints) {
  const Payload p(frame.payload);
  if (p.size() < 4 || (p.size() - 4) % 8 != 0) return complaints.damage("B062", "ESF-RAW of unknown length", frame.at);
  std::vector<SensorSample> complete;
  for (std::size_t at = 4; at < p.size(); at += 8)
    if (!raw_sensors_.add(p.u4(at + 4), p.u4(at), complete))
      complaints.note("B065", "data of ESF-RAW of a type that is not read", frame.at);
  add_sensors(complete, Kind::imu_raw, frame.at, items, &complaints);
}

void Decoder::add_sensors(std::vector<SensorSample>& samples, Kind inertial, std::uint64_t at, std::vector<Item>& items,
                          Complaints* complaints) const {
  for (SensorSample& sample : samples) {
    if (sample.t == no_time) {
      if (complaints)
        complaints->note("B065", "samples of sensors before the first epoch, so that they have no time", at);
      continue;
    }
    if (sample.is_wheels && inertial == Kind::imu_raw) {
      if (complaints) complaints->note("B065", "wheel ticks in ESF-RAW, which are not read", at);
      continue;
    }
    Item item;
    item.kind = sample.is_wheels ? Kind::wheels : inertial;
    item.t = sample.t + options_.sensor_shift;
    if (sample.t0 != no_time) item.t0 = sample.t0 + options_.sensor_shift;
    item.at = at;
    item.values = std::move(sample.values);
    items.push_back(std::move(item));
  }
  samples.clear();
}

void Decoder::finish(std::vector<Item>& items) {
  std::vector<SensorSample> complete;
  sensors_.finish(complete);
  add_sensors(complete, Kind::imu, 0, items, nullptr);
  raw_sensors_.finish(complete);
  add_sensors(complete, Kind::imu_raw, 0, items, nullptr);
}

}  // namespace binnacle::ublox
