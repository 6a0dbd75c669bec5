// SPDX-License-Identifier: Apache-2.0
// Numbers and times as the formats write them.
#pragma once

#include <string>
#include <vector>

#include "civil_time/utc_clock.hpp"
#include "convert/track.hpp"

namespace binnacle::convert {

/// With so many decimals, in the C locale.
void append_fixed(std::string& text, double value, int decimals);
/// The shortest that reads back as the same double; "nan" where it is none.
void append_exact(std::string& text, double value);

/// Decimals of a second that tell all of them apart: 3, or 6 where one is not near a millisecond.
int decimals_of(const std::vector<Record>& records);
/// A time of the calendar, rounded: "2026-11-23T12:00:00.200" with `between` 'T' and '-'.
std::string calendar(Time since_1970, int decimals, char of_date, char between);
/// "2026-11-23T12:00:00.200Z". An inserted second has the label of the one after it, as in Unix time.
std::string iso(const civil_time::Utc& utc, int decimals);

constexpr double degrees(double angle) { return angle * (180 / 3.14159265358979323846); }

}  // namespace binnacle::convert
