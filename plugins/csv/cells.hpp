// SPDX-License-Identifier: Apache-2.0
// From a line to its cells, from a cell to a number or a time.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::csv {

/// The cells of a line without surrounding blanks and quotes. A delimiter ' ' stands for any run of blanks.
void split(std::string_view line, char delimiter, std::vector<std::string_view>& cells);

enum class CellFault { none, empty, not_a_number, out_of_range };

/// A decimal number in the C locale; nan and inf are numbers here.
CellFault parse_number(std::string_view cell, double& value);

/// A decimal number of units of `unit` nanoseconds each, rounded once, to the nearest nanosecond.
CellFault parse_time(std::string_view cell, std::int64_t unit, Time& value);

/// Nanoseconds as seconds, exactly: "12.5 s".
std::string time_text(Time t);

/// The candidate most like `name`, "" if none is.
std::string closest(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace binnacle::csv
