// SPDX-License-Identifier: Apache-2.0
// Numbers and times in fixed columns, as FORTRAN writes them.
#pragma once

#include <optional>
#include <string_view>

#include "binnacle/time.hpp"
#include "text/trimmed.hpp"

namespace binnacle::rinex {

/// `width` characters from column `first` (from 0), as many as the line has.
std::string_view columns(std::string_view line, std::size_t first, std::size_t width);

/// Fw.d and Dw.d: "-.5570D-11", " 1.0E+03". Nothing if it is blank or no number.
std::optional<double> number(std::string_view text);
std::optional<int> integer(std::string_view text);

/// Year (two digits: 1980 … 2079), month, day, hour, minute and second. Nothing unless each is in its range.
/// From the begin of GPS week `origin_week`.
std::optional<Time> gps_time(std::string_view year, std::string_view month, std::string_view day, std::string_view hour,
                             std::string_view minute, std::string_view second, int origin_week);

}  // namespace binnacle::rinex
