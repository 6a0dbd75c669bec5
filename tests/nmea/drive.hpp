// SPDX-License-Identifier: Apache-2.0
// The quickstart's drive and estimates as NMEA and as JSON, to hold one against the other.
#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include <nlohmann/json.hpp>

#include "binnacle/time.hpp"
#include "command.hpp"
#include "nmea/sentence.hpp"
#include "receivers.hpp"

namespace binnacle::drive {

inline constexpr double degree = std::numbers::pi / 180;
inline constexpr double knot = 1852.0 / 3600;

/// Midnight comes two minutes after time zero.
inline constexpr const char* epoch = "2026-11-23T23:58:00Z";
inline constexpr const char* geoid_separation = "47.5 m";

/// Half of the last digit that sentences have, and what doubles lose.
inline constexpr double half_a_digit_of_angle = 0.5e-7 / 60 * degree + 1e-13;
inline constexpr double half_a_digit_of_height = 0.5e-3 + 1e-9;
inline constexpr double half_a_digit_of_speed = 0.5e-3 * knot + 1e-12;
inline constexpr double half_a_digit_of_bearing = 0.5e-3 * degree + 1e-12;

inline double turn_between(double a, double b) { return std::remainder(a - b, 2 * std::numbers::pi); }

/// "$BODY*hh"
inline std::string sentence(const std::string& body) {
  static constexpr char hex[] = "0123456789ABCDEF";
  const auto sum = nmea::checksum(body);
  return "$" + body + "*" + hex[sum >> 4] + hex[sum & 15];
}

/// A sink with these members, as JSON.
inline std::string nmea_writer(const std::string& input, const std::string& to, const std::string& more = {}) {
  const std::string fields =
      input == "ins" ? R"(, "fields": {"lat": "position.lat", "lon": "position.lon", "height": "position.height",
                          "vn": "velocity.vn", "ve": "velocity.ve", "yaw": "attitude.yaw"})"
                     : "";
  return R"({"type": "nmea_writer", "input": ")" + input + R"(", "to": ")" + to + R"(", "epoch": ")" + epoch +
         R"(", "geoid_separation": ")" + geoid_separation + "\"" + fields + more + "}";
}

inline std::string json_writer(const std::string& input, const std::string& to) {
  return R"({"type": "stream/json_writer", "input": ")" + input + R"(", "to": ")" + to + "\"}";
}

inline std::string config(const std::string& sinks, const std::string& sources = "{}") {
  return "{\"extends\": \"" BINNACLE_TEST_PROJECT "/configs/quickstart.json\", \"sources\": " + sources +
         ", \"sinks\": {" + sinks + "}}";
}

/// Samples of a file of JSON lines, by time in nanoseconds.
inline std::map<Time, nlohmann::json> samples_of(const std::string& text) {
  std::map<Time, nlohmann::json> samples;
  for (const auto& line : receivers::lines_of(text)) {
    auto object = nlohmann::json::parse(line);
    const Time t = nanoseconds(object.at("t").get<double>());
    samples[t] = std::move(object);
  }
  return samples;
}

}  // namespace binnacle::drive
