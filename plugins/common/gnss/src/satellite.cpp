// SPDX-License-Identifier: Apache-2.0
// Which satellite: constellation and number as one integer, and as text.
#include "gnss/satellite.hpp"

namespace binnacle::gnss {

std::optional<SatelliteKey> parse_satellite(std::string_view text) {
  if (text.size() < 2 || text.size() > 3) return std::nullopt;
  auto constellation = Constellation::gps;
  if (text.size() == 3) {
    const char letter = text.front();
    if (letter == 'E') {
      constellation = Constellation::galileo;
    } else if (letter == 'C') {
      constellation = Constellation::beidou;
    } else if (letter != 'G' && letter != ' ') {
      return std::nullopt;
    }
    text.remove_prefix(1);
  }
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!digit(text[1]) || !(digit(text[0]) || text[0] == ' ')) return std::nullopt;
  const int number = (text[0] == ' ' ? 0 : text[0] - '0') * 10 + (text[1] - '0');
  if (number < 1 || number > (constellation == Constellation::gps ? 32 : most_satellites(constellation)))
    return std::nullopt;
  return satellite_key(constellation, number);
}

std::string satellite_name(SatelliteKey key) {
  const char letter = "?GEC"[static_cast<std::size_t>(constellation_of(key))];
  const auto number = key % 100;
  return letter + std::string(number < 10 ? "0" : "") + std::to_string(number);
}

}  // namespace binnacle::gnss
