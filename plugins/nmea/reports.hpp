// SPDX-License-Identifier: Apache-2.0
// What is said of sentences that were of no use.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "decoder.hpp"

namespace binnacle::nmea {

inline const char* words_of(Decoder::Outcome outcome) {
  switch (outcome) {
    case Decoder::Outcome::cut: return "cut, or without a checksum";
    case Decoder::Outcome::checksum: return "of which the checksum is wrong";
    default: return "with a field that cannot be read";
  }
}

inline const char* code_of(Decoder::Outcome outcome) {
  return outcome == Decoder::Outcome::unreadable ? "B062" : "B061";
}

/// Calls note(code, which count, "is left out: …") for each.
template <class Note>
void for_each_note(Note&& note) {
  using Counts = Decoder::Counts;
  note("B065", &Counts::undated, "epochs before the first date (RMC, ZDA) were left out; 'date' gives it");
  note("B063", &Counts::backwards, "epochs are not younger than the one before, and were left out");
  note("B065", &Counts::after_end,
       "sentences came after the one that ends their epoch, and were left out; 'ends_with' names the last one");
  note("B065", &Counts::untimed,
       "sentences VTG, HDT, THS or GSA have no time of their own and were left out: there is one in an epoch");
  note("B065", &Counts::two_talkers,
       "sentences are of two talkers for one instant, and the later counts; 'talkers' chooses");
  note("B064", &Counts::no_separation,
       "GGA have a height above the sea alone, so there is none above the ellipsoid; 'geoid_separation' gives the "
       "difference");
}

/// "not read: GSV (12), …"; empty: there are none.
inline std::string text_of(const std::map<std::string, std::int64_t>& passed_over) {
  std::string text;
  for (const auto& [kind, count] : passed_over)
    text += (text.empty() ? "not read: " : ", ") + kind + " (" + std::to_string(count) + ")";
  return text;
}

}  // namespace binnacle::nmea
