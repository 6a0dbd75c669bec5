// SPDX-License-Identifier: Apache-2.0
// Sentences of NMEA 0183: written with their checksum, and taken apart.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "civil_time/utc_clock.hpp"

namespace binnacle::nmea {

using civil_time::Day;
using civil_time::parse_day;
using civil_time::parse_instant;
using civil_time::Utc;
using civil_time::UtcClock;

/// Of what stands between '$' and '*'.
std::uint8_t checksum(std::string_view body);

/// Appends sentences to a text, field by field.
class SentenceWriter {
 public:
  /// `text` outlives this.
  SentenceWriter(std::string& text, std::string_view talker, std::string_view type);
  /// '*', the checksum and CR LF.
  void end();

  void empty() { text_ += ','; }
  void word(std::string_view field);
  void letter(char field) { word({&field, 1}); }
  /// "12.340"; empty where it is not finite.
  void number(double value, int decimals);
  /// [rad] as degrees from 0 up to 360; empty where it is not finite.
  void bearing(double angle, int decimals);
  /// [rad] as "4807.0380000,N", degrees and minutes; empty fields where it is not finite.
  void latitude(double angle) { coordinate(angle, 2, "NS"); }
  void longitude(double angle) { coordinate(angle, 3, "EW"); }
  /// "123519.000"
  void time_of_day(Time of_day);
  /// "230394"
  void date(Day day);

 private:
  void coordinate(double angle, int digits, std::string_view signs);
  void digits(std::int64_t value, int count);

  std::string& text_;
  std::size_t begin_;
};

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
