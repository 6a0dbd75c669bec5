// SPDX-License-Identifier: Apache-2.0
// Sentences of NMEA 0183 as they are written: field by field, with their checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "civil_time/utc_clock.hpp"

namespace binnacle::sentences {

using civil_time::Day;
using civil_time::Utc;

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

}  // namespace binnacle::sentences
