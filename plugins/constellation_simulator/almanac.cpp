// SPDX-License-Identifier: Apache-2.0
// YUMA almanacs: a block of lines "name: value" for each satellite.
#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "constellation.hpp"
#include "text/text_file.hpp"
#include "text/trimmed.hpp"

namespace binnacle::constellation_simulator {

namespace {

std::optional<double> read_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool begins(std::string_view text, std::string_view with) { return text.substr(0, with.size()) == with; }

/// Where a line's number goes; nothing for what an ephemeris has no place for (the week).
double* member(gnss::Ephemeris& satellite, std::string_view name) {
  if (begins(name, "Eccentricity")) return &satellite.eccentricity;
  if (begins(name, "Time of Applicability")) return &satellite.toe;
  if (begins(name, "Orbital Inclination")) return &satellite.i0;
  if (begins(name, "Rate of Right Ascen")) return &satellite.omega_dot;
  if (begins(name, "SQRT(A)")) return &satellite.semi_major_axis;
  if (begins(name, "Right Ascen at Week")) return &satellite.omega0;
  if (begins(name, "Argument of Perigee")) return &satellite.perigee;
  if (begins(name, "Mean Anom")) return &satellite.m0;
  if (begins(name, "Af0")) return &satellite.af0;
  if (begins(name, "Af1")) return &satellite.af1;
  return nullptr;
}

}  // namespace

std::vector<gnss::Ephemeris> read_almanac(const std::string& path) {
  std::vector<gnss::Ephemeris> almanac;
  int line_number = 0;
  const auto damaged = [&](const std::string& what) {
    return ComponentError::in_data(what, path, line_number, "B061");
  };
  try {
    text_file::LineReader reader(path);
    std::optional<gnss::Ephemeris> satellite;
    bool is_healthy = true;
    const auto finish = [&] {
      if (!satellite) return;
      satellite->toc = satellite->toe;
      if (is_healthy && !gnss::is_usable(*satellite))
        throw damaged(gnss::satellite_name(satellite->satellite) + ": the almanac's lines do not form an orbit");
      if (is_healthy) almanac.push_back(*satellite);
      satellite.reset();
    };
    for (std::string_view line; reader.next(line);) {
      line_number = reader.line();
      const auto colon = line.find(':');
      if (colon == std::string_view::npos) continue;  // headings and blank lines
      const std::string_view name = trimmed(line.substr(0, colon), " \t\r");
      const auto value = read_number(trimmed(line.substr(colon + 1), " \t\r"));
      if (!value) throw damaged("'" + std::string(name) + "' is followed by no number");
      if (begins(name, "ID")) {
        finish();
        if (!(*value >= 1 && *value <= 32)) throw damaged("a satellite's ID is 1 to 32");
        satellite = gnss::Ephemeris{};
        satellite->satellite = gnss::satellite_key(gnss::Constellation::gps, static_cast<int>(*value));
        if (std::any_of(almanac.begin(), almanac.end(),
                        [&](const gnss::Ephemeris& other) { return other.satellite == satellite->satellite; }))
          throw damaged(gnss::satellite_name(satellite->satellite) +
                        " appears twice: the almanac of a week contains it once");
        is_healthy = true;
      } else if (!satellite) {
        throw damaged("'" + std::string(name) + "' comes before the first ID");
      } else if (begins(name, "Health")) {
        is_healthy = *value == 0;
      } else if (double* const place = member(*satellite, name)) {
        *place = begins(name, "SQRT(A)") ? *value * *value : *value;
      }
    }
    finish();
  } catch (const text_file::FileFault& fault) {
    throw ComponentError::in_data(fault.what(), path, line_number, fault.code);
  }
  if (almanac.empty()) throw damaged("it contains no healthy satellite");
  return almanac;
}

}  // namespace binnacle::constellation_simulator
