// SPDX-License-Identifier: Apache-2.0
// Broadcast messages of a RINEX navigation file.
#include "navigation_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "binnacle/parameters.hpp"
#include "columns.hpp"
#include "gnss/gps_time.hpp"
#include "header.hpp"

namespace binnacle::rinex {

namespace {

constexpr int lines_of_orbit = 7;  // after the line of the clock
constexpr std::size_t orbit_width = 19;

/// A message as it stands: RINEX 2.11 table A4, RINEX 3.04 tables A6, A8 and A14.
enum Orbit {
  iode,
  crs,
  delta_n,
  m0,
  cuc,
  eccentricity,
  cus,
  sqrt_a,
  toe,
  cic,
  omega0,
  cis,
  i0,
  crc,
  perigee,
  omega_dot,
  i_dot,
  data_sources,
  week,
  l2p,
  accuracy,
  health,
  group_delay,
  group_delay_2,
  transmission,
  orbit_numbers
};

/// Bits of Galileo's data sources (RINEX 3.04 table A8): pages from E1-B or E5b-I, from E5a-I; whose clock it is.
enum Sources : long { is_inav = 0b101, is_fnav = 0b10, clock_of_E5a = 1 << 8, clock_of_E5b = 1 << 9 };

bool is_beidou(gnss::SatelliteKey key) { return gnss::constellation_of(key) == gnss::Constellation::beidou; }

struct Record {
  gnss::SatelliteKey satellite = 0;
  int line = 0;
  Time toc = no_time;
  std::array<std::optional<double>, 3> clock;
  std::array<std::optional<double>, 4 * lines_of_orbit> orbit;
};

class NavigationReader {
 public:
  NavigationReader(const std::string& path, int origin_week, Faults& faults)
      : path_(path), origin_week_(origin_week), faults_(faults) {}

  Navigation read() {
    try {
      text_file::LineReader reader(path_);
      version_ = read_version(reader, path_, FileType::navigation);
      if (read_header(reader)) read_records(reader);
    } catch (const text_file::FileFault& fault) {
      faults_.add(fault.code, 0, "rest of the file", fault.what());
    }
    if (glonass_ > 0)
      faults_.note("B065", first_glonass_,
                   std::to_string(glonass_) + (glonass_ == 1 ? " message" : " messages") +
                       " of GLONASS left out: it is not read");
    return std::move(navigation_);
  }

 private:
  bool read_header(text_file::LineReader& reader) {
    std::string_view line;
    while (reader.next_filled(line)) {
      const auto name = label(line);
      if (name == "END OF HEADER") {
        finish_klobuchar();
        return true;
      }
      if (name == "ION ALPHA") read_coefficients(columns(line, 2, 48), alpha_, reader.line());
      if (name == "ION BETA") read_coefficients(columns(line, 2, 48), beta_, reader.line());
      if (name == "IONOSPHERIC CORR" && columns(line, 0, 4) == "GPSA")
        read_coefficients(columns(line, 5, 48), alpha_, reader.line());
      if (name == "IONOSPHERIC CORR" && columns(line, 0, 4) == "GPSB")
        read_coefficients(columns(line, 5, 48), beta_, reader.line());
    }
    faults_.add("B061", reader.line(), "header", "the file ends inside its header");
    return false;
  }

  void read_coefficients(std::string_view text, std::optional<std::array<double, 4>>& to, int line) {
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < 4; ++i) {
      const auto value = number(columns(text, 12 * i, 12));
      if (!value) return faults_.add("B062", line, "header line", "ionosphere coefficients are not four numbers");
      values[i] = *value;
    }
    to = values;
  }

  void finish_klobuchar() {
    if (!alpha_ || !beta_) return;
    navigation_.klobuchar.emplace();
    std::copy(alpha_->begin(), alpha_->end(), navigation_.klobuchar->alpha);
    std::copy(beta_->begin(), beta_->end(), navigation_.klobuchar->beta);
  }

  /// A record begins where its continuation lines have blanks.
  bool begins_record(std::string_view line) const {
    return !trimmed(columns(line, 0, version_.major() == 2 ? 2 : 3)).empty();
  }

  void read_records(text_file::LineReader& reader) {
    std::string_view line;
    bool has_line = reader.next_filled(line);
    while (has_line) {
      if (trimmed(line).empty()) {
        has_line = reader.next_filled(line);
        continue;
      }
      const std::string first(line);
      const int first_line = reader.line();
      if (!begins_record(first)) {
        faults_.add("B062", first_line, "line",
                    "a message begins with its satellite; '" + first.substr(0, 20) + "' does not");
        while ((has_line = reader.next_filled(line)) && !begins_record(line)) {
        }
        continue;
      }
      std::vector<std::string> rest;
      while ((has_line = reader.next_filled(line)) && !begins_record(line))
        if (!trimmed(line).empty()) rest.emplace_back(line);
      take_record(first, first_line, rest, !has_line);
    }
  }

  void take_record(const std::string& first, int line, const std::vector<std::string>& rest, bool is_last) {
    const bool is_old = version_.major() == 2;
    const auto satellite = gnss::parse_satellite(columns(first, 0, is_old ? 2 : 3));
    if (!satellite) {
      const char system = first.front();
      if (system == 'R' && !is_old && ++glonass_ == 1) first_glonass_ = line;
      if (is_old || std::string_view("RSJI").find(system) == std::string_view::npos)
        faults_.add("B062", line, "message", "'" + first.substr(0, is_old ? 2 : 3) + "' is not a satellite");
      return;
    }
    const std::string name = gnss::satellite_name(*satellite);
    if (rest.size() != lines_of_orbit)
      return faults_.add(is_last ? "B061" : "B062", line, "message",
                         (is_last ? "the file ends inside the message of " : "the message of ") + name +
                             (is_last ? "" : " has " + std::to_string(rest.size() + 1) + " lines instead of 8"));
    Record record;
    record.satellite = *satellite;
    record.line = line;
    const std::size_t shift = is_old ? 0 : 1;  // a letter before the number; and the year has four digits
    const std::size_t year = is_old ? 2 : 4, after = is_old ? 5 : 8;
    const auto toc = gps_time(columns(first, year, is_old ? 3 : 4), columns(first, after, 3),
                              columns(first, after + 3, 3), columns(first, after + 6, 3), columns(first, after + 9, 3),
                              columns(first, after + 12, is_old ? 5 : 3), origin_week_);
    if (!toc) return faults_.add("B062", line, "message", "the time of the clock of " + name + " is none");
    record.toc = *toc + (is_beidou(*satellite) ? nanoseconds(gnss::gps_minus_beidou) : 0);
    for (std::size_t i = 0; i < 3; ++i)
      record.clock[i] = number(columns(first, 22 + shift + i * orbit_width, orbit_width));
    for (std::size_t i = 0; i < rest.size(); ++i)
      for (std::size_t j = 0; j < 4; ++j)
        record.orbit[4 * i + j] = number(columns(rest[i], 3 + shift + j * orbit_width, orbit_width));
    take_message(record, name);
  }

  static void take_orbit(const Record& record, gnss::Ephemeris& e) {
    const auto value = [&](Orbit which) { return *record.orbit[which]; };
    e.semi_major_axis = value(sqrt_a) * value(sqrt_a);
    e.eccentricity = value(eccentricity);
    e.i0 = value(i0);
    e.omega0 = value(omega0);
    e.perigee = value(perigee);
    e.m0 = value(m0);
    e.delta_n = value(delta_n);
    e.omega_dot = value(omega_dot);
    e.i_dot = value(i_dot);
    e.cuc = value(cuc), e.cus = value(cus);
    e.crc = value(crc), e.crs = value(crs);
    e.cic = value(cic), e.cis = value(cis);
  }

  void take_message(const Record& record, const std::string& name) {
    const auto refuse = [&](const std::string& why) { faults_.add("B062", record.line, "message", name + ": " + why); };
    for (const auto& value : record.clock)
      if (!value) return refuse("a coefficient of the clock is not a number");
    for (const Orbit needed : {iode,   crs, delta_n, m0,  cuc,     eccentricity, cus,   sqrt_a, toe,    cic,
                               omega0, cis, i0,      crc, perigee, omega_dot,    i_dot, week,   health, group_delay})
      if (!record.orbit[needed])
        return refuse("number " + std::to_string(needed + 1) + " of the orbit, in line " +
                      std::to_string(record.line + 1 + needed / 4) + ", is none");
    const auto value = [&](Orbit which) { return *record.orbit[which]; };
    const bool is_galileo = gnss::constellation_of(record.satellite) == gnss::Constellation::galileo;
    const auto bits = [&](Orbit which) {
      return static_cast<long>(std::clamp(record.orbit[which].value_or(0), 0.0, 1e6));
    };
    const long sources = bits(data_sources);
    if (is_galileo && (sources & (is_inav | is_fnav)) == 0)
      return refuse("its data sources, " + std::to_string(sources) + ", name neither I/NAV nor F/NAV");
    const bool is_fnav_only = is_galileo && (sources & is_inav) == 0;

    Message message;
    message.line = record.line;
    gnss::Ephemeris& e = message.ephemeris;
    e.satellite = record.satellite;
    // Weeks and seconds of week of BeiDou are its own.
    const double first_week = is_beidou(record.satellite) ? gnss::beidou_week_zero : 0;
    const double origin = (value(week) + first_week - origin_week_) * static_cast<double>(gnss::seconds_per_week) +
                          (is_beidou(record.satellite) ? gnss::gps_minus_beidou : 0);
    e.toe = origin + value(toe);
    e.toc = seconds(record.toc);
    take_orbit(record, e);
    e.af0 = *record.clock[0], e.af1 = *record.clock[1], e.af2 = *record.clock[2];
    // Galileo on E1 (OS SIS ICD 5.1.5): BGD(E1, E5a) where the clock is that of E1 and E5a, else BGD(E1, E5b), the second.
    const long clock = sources & (clock_of_E5a | clock_of_E5b);
    const bool is_of_E5a = clock == clock_of_E5a || (clock != clock_of_E5b && is_fnav_only);
    e.group_delay =
        is_galileo && !is_of_E5a ? record.orbit[group_delay_2].value_or(value(group_delay)) : value(group_delay);
    e.accuracy = std::max(0.0, record.orbit[accuracy].value_or(0));
    e.issue = value(iode);
    if (!gnss::is_usable(e)) return refuse("the orbit or clock is not plausible for a satellite");
    if (std::abs(e.toe - e.toc) > 86400) return refuse("toe and toc are more than a day apart");
    message.toe = nanoseconds(e.toe);
    // Galileo: validity and health of E1-B, bits 0 to 2; F/NAV knows those of E5a alone, bits 3 to 5.
    message.is_healthy = is_galileo ? (bits(health) & (is_fnav_only ? 0b111000 : 0b111)) == 0 : value(health) == 0;
    message.is_substitute = is_fnav_only;
    const double sent = record.orbit[transmission].value_or(9999e5);
    double uploaded = origin + (std::abs(sent) < 1e6 ? sent : value(toe) - 7200);
    // Given in seconds of its own week or of toe's: the nearer to toe.
    uploaded += std::round((e.toe - uploaded) / gnss::seconds_per_week) * gnss::seconds_per_week;
    message.uploaded = nanoseconds(uploaded);
    navigation_.messages.push_back(message);
  }

  const std::string& path_;
  int origin_week_;
  Faults& faults_;
  Version version_;
  std::size_t glonass_ = 0;  // messages
  int first_glonass_ = 0;    // line
  std::optional<std::array<double, 4>> alpha_, beta_;
  Navigation navigation_;
};

}  // namespace

Navigation read_navigation(const std::string& path, int origin_week, Faults& faults) {
  return NavigationReader(path, origin_week, faults).read();
}

}  // namespace binnacle::rinex
