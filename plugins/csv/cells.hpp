// SPDX-License-Identifier: Apache-2.0
// From a line to its cells, from a cell to a number or a time.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::csv {

/// Every power of ten up to 10^22 is a double exactly.
inline constexpr std::array<double, 23> exact_powers_of_ten{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                            1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                            1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

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
