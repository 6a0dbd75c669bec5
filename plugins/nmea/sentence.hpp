// SPDX-License-Identifier: Apache-2.0
// Sentences of NMEA 0183, taken apart.
#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string_view>

#include "civil_time/utc_clock.hpp"
#include "sentences/sentence_writer.hpp"

namespace binnacle::nmea {

inline constexpr double degree = std::numbers::pi / 180;  // [rad]

using civil_time::Day;
using civil_time::parse_day;
using civil_time::parse_instant;
using civil_time::Utc;
using civil_time::UtcClock;
using sentences::checksum;

enum class SentenceFault { none, no_sentence, cut, checksum };

/// A sentence that was received. Views into the line.
struct Sentence {
  static constexpr std::size_t most_fields = 40;
  std::string_view talker;                           // "GP"
  std::string_view type;                             // "GGA"
  std::array<std::string_view, most_fields> fields;  // from 1; fields[0] is the address
  std::size_t count = 0;

  /// "" where the sentence ends before it.
  std::string_view operator[](std::size_t i) const { return i < count ? fields[i] : std::string_view(); }
};

/// What stands before its '$' is passed over. `no_sentence`: a line without one, a query or a proprietary one but for PASHR
/// (talker "PA", type "SHR").
SentenceFault parse(std::string_view line, Sentence& sentence);

/// A decimal number; empty where the field is, false where it is none.
bool parse_number(std::string_view field, std::optional<double>& value);
/// The same, with a sign.
bool parse_signed(std::string_view field, std::optional<double>& value);
/// hhmmss.sss [ns]; a leap second may be 60.
bool parse_time_of_day(std::string_view field, std::optional<Time>& value);
/// "4807.038", "N" [rad].
bool parse_coordinate(std::string_view field, std::string_view sign, std::optional<double>& value);

}  // namespace binnacle::nmea
