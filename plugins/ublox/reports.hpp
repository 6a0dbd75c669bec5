// SPDX-License-Identifier: Apache-2.0
// What is said of bytes and messages that were of no use.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "framer.hpp"
#include "kinds.hpp"

namespace binnacle::ublox {

/// Calls report(code, text, where the first is) for each kind that there is.
template <class Report>
void for_each_count(const Framer::Counts& counts, Report&& report) {
  const auto number = [](std::uint64_t n, const char* of) {
    return std::to_string(n) + " " + of + (n == 1 ? "" : "s");
  };
  if (counts.garbage.count > 0)
    report("B061", number(counts.garbage.count, "byte") + " between messages belong to none", counts.garbage.first_at);
  if (counts.bad_checksums.runs > 0)
    report("B061", number(counts.bad_checksums.runs, "message") + " of which the checksum is wrong",
           counts.bad_checksums.first_at);
  if (counts.cut.count > 0)
    report("B061", "the data end inside a message, " + number(counts.cut.count, "byte"), counts.cut.first_at);
  if (counts.text.count > 0)
    report("B065", number(counts.text.runs, "line") + " of text, like those of NMEA, are not read",
           counts.text.first_at);
}

/// "messages that are not read: NAV-SAT (536), …"; empty: there are none.
inline std::string text_of(const std::map<int, std::uint64_t>& passed_over) {
  std::string text;
  for (const auto& [type, count] : passed_over)
    text += (text.empty() ? "messages that are not read: " : ", ") + message_name(type) + " (" + std::to_string(count) +
            ")";
  return text;
}

inline std::string channel_name(Kind kind) {
  for (const ValueKind& each : value_kinds())
    if (each.kind == kind) return each.channel;
  return kind == Kind::obs ? "obs" : "ephemeris";
}

}  // namespace binnacle::ublox
