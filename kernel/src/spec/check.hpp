// SPDX-License-Identifier: Apache-2.0
// Checking JSON against specs, kinds against ports; and what a spec asks for, in words.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/section.hpp"
#include "config/document.hpp"

namespace binnacle::internal::spec {

using config::Document;
using config::JsonOf;
using Json = nlohmann::ordered_json;

/// Whether a component takes the field whatever unit the channel has for it.
inline bool takes_any_unit(const FieldSpec& field) { return field.unit.empty() || field.unit == "*"; }

/// What a component's author got wrong in its spec: a unit that is none, a default that its own check refuses, a name
/// twice. One line each.
std::vector<std::string> spec_defects(const ComponentSpec& spec);

/// Block kinds, "velocity.ned" or "rates:3:rad/s", against a port's pattern: part by part between colons, `*` for any, a
/// lone `*` for every kind; units by dimension: "rates:*:deg/s" matches "rates:3:rad/s".
bool kind_matches(std::string_view pattern, std::string_view kind);

/// The kind with its units in canonical SI text ("rates:3:1/s*rad" is "rates:3:rad/s"), or a refusal of a unit that
/// is not SI. The first part is never a unit.
Parsed<std::string> canonical_kind(std::string_view kind);

/// The unit that a spec asks for. No dimension: any will do ("*", or a port that is open).
struct WantedUnit {
  std::optional<Dimension> dimension;
  std::string text;  // "s", "m/sqrt(s)", "unit of x/sqrt(s)", "any unit"; "1" for a plain number
};

/// Nothing for a port that is unknown or open.
std::optional<PortMeasure> measure_of(const PortUnits& ports, std::string_view port);

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

/// "s, > 0" — unit and range, or what else a value has to be. `ports` fill in units that begin with '@'.
std::string describe_short(const ParameterSpec& spec, const PortUnits& ports = {});

/// The default, or a quantity as one would write it, inside the spec's range: "1 h". As JSON text, with its quotes.
std::string example_of(const ParameterSpec& spec, const PortUnits& ports = {});

/// "a number or quantity (s, > 0), for example \"1 h\"", "one of 'a', 'b'", "a list of rows".
std::string expected_text(const ParameterSpec& spec, const PortUnits& ports);

/// "s, > 0": the unit, unless it is a plain number's, and the range.
std::string unit_and_range(const ParameterSpec& spec, const PortUnits& ports);

/// "a, b"; one alone where the other is empty.
std::string joined(const std::string& a, const std::string& b);

}  // namespace binnacle::internal::spec
