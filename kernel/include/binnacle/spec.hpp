// SPDX-License-Identifier: Apache-2.0
// What a component says of itself, once, before it exists: parameters, ports, fields. Checked, documented and turned
// into a JSON Schema by the kernel from this one description.
#pragma once

#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace binnacle {

/// Sets a member of a spec that is being written.
template <class Spec, class T>
Spec&& with(Spec& spec, T& member, std::type_identity_t<T> value) {
  member = std::move(value);
  return std::move(spec);
}

/// What a parameter is in JSON.
enum class ParameterType { number, integer, boolean, text, choice, path, vector, matrix, time, list, map, object };

/// One parameter of a component.
///
/// Numbers, vectors and matrices carry the SI unit in which the plugin receives them; in JSON they are a plain number
/// (SI) or text with any unit of the same dimension, "0.2 deg/h". A unit that begins with `@port` is the unit of the
/// error components of the block bound to that port, times what follows: `@x/sqrt(s)`. A parameter without default and
/// not required is absent unless given. Written with the functions below:
///
///     number("tau", "s").above(0).required().about("correlation time")
///     vector("lever_arm", "m", 3).about("from the IMU to the antenna, body axes")
struct ParameterSpec {
  static constexpr int any_size = -1;

  std::string name;
  ParameterType type = ParameterType::number;
  std::string unit;  // SI text, "" where it has no meaning, "1" for a pure number
  std::string text;  // one line
  bool is_required = false;
  std::string default_json;  // JSON text of the default, in the notation of a config; "" = none
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
  bool maximum_excluded = false;
  double least_plausible = 0;
  double most_plausible = std::numeric_limits<double>::infinity();
  int size = any_size;       // vector: length; matrix: rows
  int cols = any_size;       // matrix
  std::string size_of_port;  // vector/matrix as long as the error dof of the block on this port
  std::vector<std::string> choices;
  std::string former_name;             // "" = it was never renamed
  std::vector<ParameterSpec> members;  // object: its keys. list, map: exactly one, the element

  /// The key that this parameter had in an earlier version: under it a config gets an error that states the new one.
  ParameterSpec&& formerly(std::string key) && { return with(*this, former_name, std::move(key)); }
  ParameterSpec&& required() && { return with(*this, is_required, true); }
  ParameterSpec&& defaults(std::string json) && { return with(*this, default_json, std::move(json)); }
  ParameterSpec&& about(std::string line) && { return with(*this, text, std::move(line)); }
  ParameterSpec&& above(double bound) && { return from(bound, true); }
  ParameterSpec&& at_least(double bound) && { return from(bound, false); }
  ParameterSpec&& below(double bound) && { return to(bound, true); }
  ParameterSpec&& at_most(double bound) && { return to(bound, false); }
  /// Bounds (SI) that no such sensor or vehicle is beyond: a number whose magnitude is, and that is not 0, is a warning
  /// (B111), since most likely its unit is missing or wrong. State wide ones, or none.
  ParameterSpec&& plausible(double least, double most) && {
    least_plausible = least;
    return with(*this, most_plausible, most);
  }
  /// As many elements (rows and columns for a matrix) as the block on `port` has error dof; one number stands for all.
  ParameterSpec&& sized_by(std::string port) && { return with(*this, size_of_port, std::move(port)); }

 private:
  ParameterSpec&& from(double bound, bool is_excluded) {
    minimum_excluded = is_excluded;
    return with(*this, minimum, bound);
  }
  ParameterSpec&& to(double bound, bool is_excluded) {
    maximum_excluded = is_excluded;
    return with(*this, maximum, bound);
  }
};

namespace parameter {

inline ParameterSpec of(std::string name, ParameterType type, std::string unit = {},
                        std::vector<ParameterSpec> members = {}) {
  ParameterSpec spec;
  spec.name = std::move(name);
  spec.type = type;
  spec.unit = std::move(unit);
  spec.members = std::move(members);
  return spec;
}
inline ParameterSpec number(std::string name, std::string unit) {
  return of(std::move(name), ParameterType::number, std::move(unit));
}
inline ParameterSpec integer(std::string name) { return of(std::move(name), ParameterType::integer, "1"); }
inline ParameterSpec boolean(std::string name) { return of(std::move(name), ParameterType::boolean); }
inline ParameterSpec text(std::string name) { return of(std::move(name), ParameterType::text); }
/// A file or folder. Relative ones start at the file that names them; the plugin receives it resolved.
inline ParameterSpec path(std::string name) { return of(std::move(name), ParameterType::path); }
/// An instant or duration: "228 s" or a number of seconds in JSON, nanoseconds (Parameters::time) in the plugin.
inline ParameterSpec time(std::string name) { return of(std::move(name), ParameterType::time, "s"); }
inline ParameterSpec choice(std::string name, std::vector<std::string> choices) {
  auto spec = of(std::move(name), ParameterType::choice);
  spec.choices = std::move(choices);
  return spec;
}
/// A vector; in JSON a list, or one number or quantity that stands for every element where the size is known.
inline ParameterSpec vector(std::string name, std::string unit, int size = ParameterSpec::any_size) {
  auto spec = of(std::move(name), ParameterType::vector, std::move(unit));
  spec.size = size;
  return spec;
}
/// A matrix; in JSON a list of rows.
inline ParameterSpec matrix(std::string name, std::string unit, int rows = ParameterSpec::any_size,
                            int cols = ParameterSpec::any_size) {
  auto spec = of(std::move(name), ParameterType::matrix, std::move(unit));
  spec.size = rows;
  spec.cols = cols;
  return spec;
}
inline ParameterSpec object(std::string name, std::vector<ParameterSpec> members) {
  return of(std::move(name), ParameterType::object, {}, std::move(members));
}
/// A JSON array, each element as `element` says.
inline ParameterSpec list(std::string name, ParameterSpec element) {
  return of(std::move(name), ParameterType::list, {}, {std::move(element)});
}
/// A JSON object with free keys, each value as `element` says.
inline ParameterSpec map(std::string name, ParameterSpec element) {
  return of(std::move(name), ParameterType::map, {}, {std::move(element)});
}

}  // namespace parameter

/// Whether a process model advances the block on a port, or a component only reads it.
enum class PortAccess { reads, advances };

/// A place where a block is plugged in: `"blocks": {"gyro_bias": "my_bias"}`.
///
/// `kind` is matched against the kind of the block (or derived block): exactly, or by its colon-separated parts with `*`
/// for any: `attitude`, `vector:3:rad/s`, `vector:*:m`, `*`. Units are compared by dimension. A block that is advanced
/// must be a state block; one that is read may be derived. An optional port that is left open costs nothing.
///
///     reads("lever_arm", "vector:3:m").optional().about("from the IMU to the antenna, body axes")
struct PortSpec {
  std::string name;
  std::string kind;
  PortAccess access = PortAccess::reads;
  bool is_optional = false;
  std::string text;
  std::string former_name = {};  // "" = it was never renamed

  PortSpec&& optional() && { return with(*this, is_optional, true); }
  PortSpec&& about(std::string line) && { return with(*this, text, std::move(line)); }
  /// The name that this port had in an earlier version: under it a config gets an error that states the new one.
  PortSpec&& formerly(std::string port) && { return with(*this, former_name, std::move(port)); }
};

inline PortSpec advances(std::string name, std::string kind, std::string text = {}) {
  return {std::move(name), std::move(kind), PortAccess::advances, false, std::move(text)};
}
inline PortSpec reads(std::string name, std::string kind, std::string text = {}) {
  return {std::move(name), std::move(kind), PortAccess::reads, false, std::move(text)};
}

/// `level`: the value at the sample's time. `rate`: the mean over its interval. `increment`: the integral over it.
enum class FieldKind { level, rate, increment };

/// A number that a channel carries or that a component wants from one.
///
/// Where a component wants a field as a rate and the channel has increments (or the reverse) the kernel converts by the
/// sample's interval; unit is then the one of the wanted kind. Units are compared by dimension; a component that takes
/// numbers of whatever unit the channel has says "*". Written with the functions below:
///
///     field::level("vn", "m/s").optional().about("velocity over ground, north")
///     field::level("pseudorange", "m").per_row()
struct FieldSpec {
  std::string name;
  std::string unit;
  FieldKind kind = FieldKind::level;
  bool is_optional = false;
  bool is_per_row = false;  // one value per row of the sample instead of one per sample
  std::string text = {};

  FieldSpec&& optional() && { return with(*this, is_optional, true); }
  FieldSpec&& per_row() && { return with(*this, is_per_row, true); }
  FieldSpec&& about(std::string line) && { return with(*this, text, std::move(line)); }
};

namespace field {

inline FieldSpec level(std::string name, std::string unit) {
  return {std::move(name), std::move(unit), FieldKind::level};
}
inline FieldSpec rate(std::string name, std::string unit) {
  return {std::move(name), std::move(unit), FieldKind::rate};
}
inline FieldSpec increment(std::string name, std::string unit) {
  return {std::move(name), std::move(unit), FieldKind::increment};
}

}  // namespace field

/// A channel that a component subscribes to under its own name for it: `"inputs": {"imu": "raw_imu", "gnss": "fix"}`; of a
/// transform or sink with a single one also `"input": "raw_imu"`.
///
///     input("anchors", {field::level("x", "m").per_row(), …}).optional().about("where the anchors are")
struct ChannelPort {
  std::string name;
  std::vector<FieldSpec> fields;
  bool is_optional = false;
  std::string text = {};
  bool is_whole = false;

  ChannelPort&& optional() && { return with(*this, is_optional, true); }
  /// Of transforms and sinks: any channel, all of its fields in its own order and kinds; Binding::channel() gives its
  /// declaration. `fields` are then an example, with which the conformance suite tries the component.
  ChannelPort&& whole() && { return with(*this, is_whole, true); }
  ChannelPort&& about(std::string line) && { return with(*this, text, std::move(line)); }
};

inline ChannelPort input(std::string name, std::vector<FieldSpec> fields) {
  return {std::move(name), std::move(fields)};
}

/// What a component type says of itself. Filled by its static `spec()`, never changed afterwards.
struct ComponentSpec {
  std::string type;     // "gauss_markov": snake_case, unique within its plugin
  std::string summary;  // one line
  std::string source;   // the paper and equation, standard or book it follows; "" where there is none
  std::vector<ParameterSpec> parameters;
  std::vector<PortSpec> ports;           // process and measurement models, derived blocks
  std::vector<FieldSpec> fields;         // process model: of the driving input. Measurement model: of its sample
  std::vector<FieldSpec> driving_rates;  // measurement model, derived block: mean rates of the last driving interval
  std::vector<ChannelPort> inputs;       // transforms, sinks. Process and measurement model: auxiliary (latest value)
  std::string kind;                      // state block: kind it has. Derived block: kind it yields (pattern)
  std::string example;                   // JSON of a working configuration of it, without "type"
  // JSON: what the example refers to and the conformance suite cannot guess: {"blocks": {…}, "sources": {…},
  // "sample": {field: SI value}, "inputs": {channel: {field: SI value}}, "time": s, "files": {name: text}}; a list of values
  // where a field is per row. "" = nothing
  std::string surroundings;
  // Full names that it had, "phi_error/position": under them a config gets an error that states the new one.
  std::vector<std::string> former_names;
};

}  // namespace binnacle
