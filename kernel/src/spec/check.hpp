// SPDX-License-Identifier: Apache-2.0
// Checking JSON against specs: parameters of components, and the values that the kernel itself reads from a config.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/unit.hpp"
#include "config/document.hpp"

namespace binnacle::spec {

using config::Document;

/// What the block on a port lends to parameters: unit of its error components, and how many there are.
struct PortMeasure {
  Dimension dimension;
  int dof = 0;
};

/// By port name; nothing for an unknown or open port. Then any unit and length is let through.
using PortUnits = std::function<std::optional<PortMeasure>(std::string_view port)>;

/// All parameters of the object at `pointer`, defaults filled in. `type_name` is how messages call it
/// ("unknown key of 'gauss_markov'"); `reserved_keys` are those of its place ("type", "init", …), left alone.
/// What is wrong goes to the diagnostics; the value is then absent, so use the result only without errors.
ParameterValue check_parameters(const std::vector<ParameterSpec>& parameters, std::string_view type_name,
                                const Document& document, const std::string& pointer,
                                const std::vector<std::string>& reserved_keys, const PortUnits& ports,
                                Diagnostics& diagnostics);

/// One value against one spec; messages call it spec.name. Absent when it is wrong or not there. A number keeps its SI
/// unit in ParameterValue::text; with the unit "*" any dimension will do, and a unit alone stands for one of it ("ms").
///
///     check_value(parameter::vector("sigma", "m", 3).at_least(0), document, pointer, {}, diagnostics)
ParameterValue check_value(const ParameterSpec& spec, const Document& document, const std::string& pointer,
                           const PortUnits& ports, Diagnostics& diagnostics);

/// Thin forms of check_value for keys that the kernel owns. Nothing when wrong or not there; whoever requires the key
/// calls require_key(). A spec's type is seen to, only name, unit and bounds matter; without a name it is called after
/// the last token of the pointer:
///
///     read_quantity(document, pointer, parameter::number("sigma", "m").at_least(0), diagnostics)
std::optional<double> read_quantity(const Document& document, const std::string& pointer, const ParameterSpec& spec,
                                    Diagnostics& diagnostics);
std::optional<std::int64_t> read_integer(const Document& document, const std::string& pointer,
                                         const ParameterSpec& spec, Diagnostics& diagnostics);
/// A duration or a channel's instant: "20 ms" or seconds.
std::optional<Time> read_time(const Document& document, const std::string& pointer, Diagnostics& diagnostics);
std::optional<std::string> read_string(const Document& document, const std::string& pointer, Diagnostics& diagnostics);
std::optional<std::string> read_path(const Document& document, const std::string& pointer, Diagnostics& diagnostics);
std::optional<bool> read_bool(const Document& document, const std::string& pointer, Diagnostics& diagnostics);
/// One name or a list of names.
std::optional<std::vector<std::string>> read_names(const Document& document, const std::string& pointer,
                                                   Diagnostics& diagnostics);

struct Window {
  When from;
  When to;
};
std::optional<When> read_when(const Document& document, const std::string& pointer, Diagnostics& diagnostics);
/// [from, to] with from < to where both count from the same.
std::optional<Window> read_window(const Document& document, const std::string& pointer, Diagnostics& diagnostics);

/// The value at the pointer, or null.
inline const nlohmann::ordered_json* value_at(const Document& document, std::string_view pointer) {
  return document.value(pointer);
}

/// Null and B006 unless the value is an object (an array); null without a word where there is none. `what` is how the
/// message calls it, quoted or not: "'evaluate'", "the config".
const nlohmann::ordered_json* object_at(const Document& document, const std::string& pointer, std::string_view what,
                                        Diagnostics& diagnostics);
const nlohmann::ordered_json* array_at(const Document& document, const std::string& pointer, std::string_view what,
                                       Diagnostics& diagnostics);

/// Keys that had another name in an earlier version: the former, and what it is called now.
using RenamedKeys = std::vector<std::pair<std::string, std::string>>;

/// B012 for every key of the object at `pointer` which is not allowed:
/// `unknown key of 'evaluate'; did you mean 'after'?`
void check_keys(const Document& document, const std::string& pointer, const std::vector<std::string>& allowed,
                std::string_view what, Diagnostics& diagnostics, const RenamedKeys& renamed = {});
/// B010 unless the object at `pointer` has the key: `missing key 'channel' of 'fix': name of a channel`. `what` is the
/// name alone, "fix".
bool require_key(const Document& document, const std::string& pointer, std::string_view key, std::string_view what,
                 std::string_view expected, Diagnostics& diagnostics);

/// Whether a component takes the field whatever unit the channel has for it.
inline bool takes_any_unit(const FieldSpec& field) { return field.unit.empty() || field.unit == "*"; }

/// What a component's author got wrong in its spec: a unit that is none, a default that its own check refuses, a name
/// twice. One line each.
std::vector<std::string> spec_defects(const ComponentSpec& spec);

/// A value in messages: `the text "abc"`, `an object`, `the number 3.5`; cut where it is long.
std::string abbreviated(const nlohmann::ordered_json& value);

}  // namespace binnacle::spec
