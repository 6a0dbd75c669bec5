// SPDX-License-Identifier: Apache-2.0
// What a spec asks for, in words: units, ranges, examples.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "binnacle/spec.hpp"
#include "binnacle/unit.hpp"
#include "spec/check.hpp"

namespace binnacle::spec {

/// The unit that a spec asks for. No dimension: any will do ("*", or a port that is open).
struct WantedUnit {
  std::optional<Dimension> dimension;
  std::string text;  // "s", "m/sqrt(s)", "unit of x/sqrt(s)", "any unit"; "1" for a plain number
};

WantedUnit wanted_unit(const ParameterSpec& spec, const PortUnits& ports);

/// "@x/sqrt(s)" refers to the port "x"; nothing for a unit of its own.
std::optional<std::string> port_of_unit(std::string_view unit);

/// Whether numbers of the spec may be written as text with a unit.
bool takes_quantities(ParameterType type);

/// In the C locale, `digits` of them, without a needless exponent.
std::string number_text(double value, int digits = 15);

/// "> 0, <= 1"; "" without bounds.
std::string range_text(const ParameterSpec& spec);
bool in_range(const ParameterSpec& spec, double value);

/// "'a', 'b', 'c'"
std::string quoted_list(const std::vector<std::string>& words);

/// "a number or quantity (s, > 0), for example \"1 h\"", "one of 'a', 'b'", "a list of rows".
std::string expected_text(const ParameterSpec& spec, const PortUnits& ports);

/// dimension_name() without the unit in parentheses: "an angular rate".
std::string bare_dimension_name(const Dimension& dimension);

}  // namespace binnacle::spec
