// SPDX-License-Identifier: Apache-2.0
// Which satellite: constellation and number as one integer, and as text.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace binnacle::gnss {

enum class Constellation { none = 0, gps = 1, galileo = 2, beidou = 3 };

/// A function, since a variable that loops go over would be a symbol of each plugin.
constexpr std::array<Constellation, 3> constellations() noexcept {
  return {Constellation::gps, Constellation::galileo, Constellation::beidou};
}

/// Constellation · 100 + number: GPS G05 is 105, Galileo E11 is 211, BeiDou C19 is 319. Of satellites that a channel gives with a number of
/// their system: system · 1000 + number. What a row is known by (row key).
using SatelliteKey = std::int64_t;

constexpr int most_satellites(Constellation constellation) noexcept {
  return constellation == Constellation::beidou ? 63 : 36;
}

constexpr SatelliteKey satellite_key(Constellation constellation, int number) noexcept {
  return static_cast<SatelliteKey>(constellation) * 100 + number;
}
constexpr Constellation constellation_of(SatelliteKey key) noexcept {
  return key > 100 && key < 200   ? Constellation::gps
         : key > 200 && key < 300 ? Constellation::galileo
         : key > 300 && key < 400 ? Constellation::beidou
                                  : Constellation::none;
}
/// From a channel's number; 0 (no satellite) unless it is one of a known constellation.
constexpr SatelliteKey satellite_key(double number) noexcept {
  if (!(number > 100 && number < 400)) return 0;
  const auto key = static_cast<SatelliteKey>(number);
  return constellation_of(key) == Constellation::none ? 0 : key;
}

/// "G05", "E11", "C19" as RINEX writes it; nothing if it is none that is known. " 5" and "G 5" are G05.
std::optional<SatelliteKey> parse_satellite(std::string_view text);
std::string satellite_name(SatelliteKey key);

}  // namespace binnacle::gnss
