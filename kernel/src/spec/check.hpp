// SPDX-License-Identifier: Apache-2.0
// Checking JSON against specs: parameters of components, and the values that the kernel itself reads from a config.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"
#include "binnacle/unit.hpp"
#include "config/document.hpp"

namespace binnacle::spec {

using config::Document;
using Json = nlohmann::ordered_json;

/// What the block on a port lends to parameters: unit of its error components, and how many there are.
struct PortMeasure {
  Dimension dimension;
  int dof = 0;
};

/// By port name; nothing for an unknown or open port. Then any unit and length is let through.
using PortUnits = std::function<std::optional<PortMeasure>(std::string_view port)>;

/// Keys that had another name in an earlier version: the former, and what it is called now.
using RenamedKeys = std::vector<std::pair<std::string, std::string>>;

/// A place of a config, what stands there, and where the errors about it go. Whatever reads a value gives nothing where
/// none stands, which is no error (require() makes it one), and where a wrong one does, which is reported.
///
///     for (const Reader& fix : Reader(document, diagnostics)["measurements"].members("'measurements'"))
///       sigma = fix["sigma"].number(parameter::number("sigma", "m").at_least(0));
class Reader {
 public:
  Reader(const Document& document, Diagnostics& diagnostics, const std::string& pointer = {});

  /// The place of a member, whether it is there or not.
  Reader operator[](std::string_view key) const;
  /// The places of all members or elements.
  std::vector<Reader> children() const;
  /// The same place with a default of the component that stands here: it has no place of its own, nor has what is in it.
  Reader with_default(const Json& json) const;

  explicit operator bool() const { return json_ != nullptr; }
  const Json* json() const { return json_; }
  const std::string& pointer() const { return pointer_; }
  /// The last token of the pointer.
  const std::string& key() const { return key_; }
  bool is_default() const { return is_default_; }
  Origin origin() const { return document_->origin(pointer_); }
  /// Where its key stands.
  Origin key_origin() const { return document_->key_origin(pointer_); }
  /// From which a relative path starts.
  std::filesystem::path folder() const { return document_->base_dir(pointer_); }

  void error(const std::string& code, const std::string& message) const {
    diagnostics_->error(code, origin(), pointer_, message);
  }
  /// At the key, not the value.
  void key_error(const std::string& code, const std::string& message) const {
    diagnostics_->error(code, key_origin(), pointer_, message);
  }

  /// Whether an object (a list) stands here; B006 where something else does. `what` is how the message calls it, quoted or
  /// not: "'evaluate'", "the config".
  bool is_object(std::string_view what) const { return is_of(Json::value_t::object, "an object", what); }
  bool is_list(std::string_view what) const { return is_of(Json::value_t::array, "a list", what); }
  std::vector<Reader> members(std::string_view what) const {
    return is_object(what) ? children() : std::vector<Reader>();
  }
  std::vector<Reader> elements(std::string_view what) const {
    return is_list(what) ? children() : std::vector<Reader>();
  }

  /// B012 for every key of the object that is not allowed: `unknown key of 'evaluate'; did you mean 'after'?`, with
  /// `detail` on the key that was meant. Returns the keys that were meant.
  std::set<std::string> check_keys(const std::vector<std::string>& allowed, std::string_view what,
                                   const RenamedKeys& renamed = {},
                                   const std::function<std::string(const std::string&)>& detail = {}) const;
  /// B010 unless the object has the key: `missing key 'channel' of 'fix': name of a channel`. `what` is the name alone.
  bool require(std::string_view key, std::string_view what, std::string_view expected) const;

  /// All parameters of the object, defaults filled in. `type_name` is how messages call it ("unknown key of
  /// 'gauss_markov'"); `reserved` are the keys of its place ("type", "init", …), left alone. Use it only without errors.
  ParameterValue parameters(const std::vector<ParameterSpec>& specs, const std::string& type_name,
                            const std::vector<std::string>& reserved = {}, const PortUnits& ports = {}) const;
  /// One value against one spec; messages call it spec.name. Absent when it is wrong or not there. A number keeps its SI
  /// unit in ParameterValue::text; with the unit "*" any dimension will do, and a unit alone stands for one of it ("ms").
  ParameterValue value(const ParameterSpec& spec, const PortUnits& ports = {}) const;

  /// Without a name in their spec, values are called by their key.
  std::optional<double> number(const ParameterSpec& spec) const {
    return read(spec, ParameterType::number, &ParameterValue::number);
  }
  std::optional<std::int64_t> integer(const ParameterSpec& spec) const {
    return read(spec, ParameterType::integer, &ParameterValue::integer);
  }
  std::optional<std::string> text() const { return read({}, ParameterType::text, &ParameterValue::text); }
  std::optional<std::string> path() const { return read({}, ParameterType::path, &ParameterValue::text); }
  std::optional<bool> boolean() const { return read({}, ParameterType::boolean, &ParameterValue::boolean); }
  /// A duration or a channel's instant: "20 ms" or seconds.
  std::optional<Time> time() const { return read(parameter::time(""), ParameterType::time, &ParameterValue::integer); }
  /// One name or a list of names.
  std::optional<std::vector<std::string>> names() const;
  std::optional<When> when() const;
  /// [from, to] with from < to where both count from the same.
  std::optional<TimeSpan> span() const;

 private:
  bool is_of(Json::value_t type, const char* name, std::string_view what) const;
  template <class T>
  std::optional<T> read(ParameterSpec spec, ParameterType type, T ParameterValue::*member) const {
    spec.type = type;
    if (spec.name.empty()) spec.name = key_;
    const ParameterValue found = value(spec);
    return found.type == ParameterValue::Type::absent ? std::nullopt : std::optional<T>(found.*member);
  }

  const Document* document_;
  Diagnostics* diagnostics_;
  std::string pointer_;
  std::string key_;
  const Json* json_;
  bool is_default_ = false;
};

/// Whether a component takes the field whatever unit the channel has for it.
inline bool takes_any_unit(const FieldSpec& field) { return field.unit.empty() || field.unit == "*"; }

/// What a component's author got wrong in its spec: a unit that is none, a default that its own check refuses, a name
/// twice. One line each.
std::vector<std::string> spec_defects(const ComponentSpec& spec);

/// A value in messages: `the text "abc"`, `an object`, `the number 3.5`; cut where it is long.
std::string abbreviated(const Json& value);

/// Block kinds, "velocity.ned" or "vector:3:rad/s", against a port's pattern: part by part between colons, `*` for any, a
/// lone `*` for every kind; units by dimension: "vector:*:deg" matches "vector:3:rad".
bool kind_matches(std::string_view pattern, std::string_view kind);

/// The kind with its units in canonical SI text ("vector:3:1/s*rad" is "vector:3:rad/s"), or a refusal of a unit that
/// is not SI. The first part is never a unit.
Parsed<std::string> canonical_kind(std::string_view kind);

}  // namespace binnacle::spec
