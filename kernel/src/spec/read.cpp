// SPDX-License-Identifier: Apache-2.0
// Reading the values that the kernel itself takes from a config.
#include <algorithm>
#include <cmath>

#include "config/node.hpp"
#include "spec/check.hpp"

namespace binnacle::spec {

using Json = nlohmann::ordered_json;

namespace {

std::string last_token(const std::string& pointer) {
  const auto tokens = config::split_pointer(pointer);
  return tokens && !tokens->empty() ? tokens->back() : pointer;
}

template <class T>
std::optional<T> read(ParameterSpec spec, ParameterType type, T ParameterValue::*member, const Document& document,
                      const std::string& pointer, Diagnostics& diagnostics) {
  spec.type = type;
  if (spec.name.empty()) spec.name = last_token(pointer);
  const ParameterValue value = check_value(spec, document, pointer, {}, diagnostics);
  return value.type == ParameterValue::Type::absent ? std::nullopt : std::optional<T>(value.*member);
}

}  // namespace

std::optional<double> read_quantity(const Document& document, const std::string& pointer, const ParameterSpec& spec,
                                    Diagnostics& diagnostics) {
  return read(spec, ParameterType::number, &ParameterValue::number, document, pointer, diagnostics);
}

std::optional<std::int64_t> read_integer(const Document& document, const std::string& pointer,
                                         const ParameterSpec& spec, Diagnostics& diagnostics) {
  return read(spec, ParameterType::integer, &ParameterValue::integer, document, pointer, diagnostics);
}

std::optional<Time> read_time(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  return read(parameter::time(""), ParameterType::time, &ParameterValue::integer, document, pointer, diagnostics);
}

std::optional<std::string> read_string(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  return read({}, ParameterType::text, &ParameterValue::text, document, pointer, diagnostics);
}

std::optional<std::string> read_path(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  return read({}, ParameterType::path, &ParameterValue::text, document, pointer, diagnostics);
}

std::optional<bool> read_bool(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  return read({}, ParameterType::boolean, &ParameterValue::boolean, document, pointer, diagnostics);
}

std::optional<std::vector<std::string>> read_names(const Document& document, const std::string& pointer,
                                                   Diagnostics& diagnostics) {
  const Json* json = document.value(pointer);
  if (!json) return std::nullopt;
  if (json->is_string()) return std::vector<std::string>{json->get<std::string>()};
  const bool are_texts =
      json->is_array() && std::all_of(json->begin(), json->end(), [](const Json& item) { return item.is_string(); });
  if (are_texts) return json->get<std::vector<std::string>>();
  diagnostics.error("B006", document.origin(pointer), pointer,
                    "'" + last_token(pointer) + "' must be a name or a list of names; found " + abbreviated(*json));
  return std::nullopt;
}

// ---- instants

namespace {

std::optional<When> refuse_when(const Document& document, const std::string& pointer, const std::string& why,
                                Diagnostics& diagnostics) {
  diagnostics.error("B024", document.origin(pointer), pointer, why + "; write \"228 s\" or \"start+60 s\"");
  return std::nullopt;
}

/// Without the prefix, if it is there, and spaces around.
bool take(std::string_view& text, std::string_view prefix) {
  const bool is_there = text.starts_with(prefix);
  if (is_there) text.remove_prefix(prefix.size());
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return is_there;
}

}  // namespace

std::optional<When> read_when(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  const Json* json = document.value(pointer);
  if (!json) return std::nullopt;
  if (json->is_number()) {
    if (std::abs(json->get<double>()) < 9.2e9) return When{from_seconds(json->get<double>()), false};
    return refuse_when(document, pointer, json->dump() + " s is beyond 292 years", diagnostics);
  }
  if (!json->is_string()) return refuse_when(document, pointer, abbreviated(*json) + " is no time", diagnostics);
  std::string_view text = json->get_ref<const std::string&>();
  take(text, "");
  When when;
  when.from_start = take(text, "start");
  if (when.from_start && text.empty()) return when;
  const bool is_negative = take(text, "-");
  if (!is_negative && !take(text, "+") && when.from_start)
    return refuse_when(document, pointer, "'" + json->get<std::string>() + "' is no time", diagnostics);
  const Parsed<std::int64_t> time = parse_time(text);
  if (!time) return refuse_when(document, pointer, time.error(), diagnostics);
  when.time = is_negative ? -*time : *time;
  return when;
}

std::optional<Window> read_window(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  const Json* json = document.value(pointer);
  if (!json) return std::nullopt;
  if (!json->is_array() || json->size() != 2) {
    diagnostics.error("B024", document.origin(pointer), pointer,
                      "a window is [from, to], for example [\"228 s\", \"258 s\"]; found " + abbreviated(*json));
    return std::nullopt;
  }
  const std::optional<When> from = read_when(document, join_pointer(pointer, 0), diagnostics);
  const std::optional<When> to = read_when(document, join_pointer(pointer, 1), diagnostics);
  if (!from || !to) return std::nullopt;
  if (from->from_start == to->from_start && from->time >= to->time) {
    diagnostics.error("B024", document.origin(pointer), pointer, "the window ends before it begins");
    return std::nullopt;
  }
  return Window{*from, *to};
}

// ---- structure

namespace {

const Json* of_type(bool (*is_right)(const Json&), const char* name, const Document& document,
                    const std::string& pointer, std::string_view what, Diagnostics& diagnostics) {
  const Json* json = document.value(pointer);
  if (!json || is_right(*json)) return json;
  diagnostics.error("B006", document.origin(pointer), pointer,
                    std::string(what) + " must be " + name + "; found " + abbreviated(*json));
  return nullptr;
}

}  // namespace

const Json* object_at(const Document& document, const std::string& pointer, std::string_view what,
                      Diagnostics& diagnostics) {
  return of_type([](const Json& j) { return j.is_object(); }, "an object", document, pointer, what, diagnostics);
}

const Json* array_at(const Document& document, const std::string& pointer, std::string_view what,
                     Diagnostics& diagnostics) {
  return of_type([](const Json& j) { return j.is_array(); }, "a list", document, pointer, what, diagnostics);
}

bool require_key(const Document& document, const std::string& pointer, std::string_view key, std::string_view what,
                 std::string_view expected, Diagnostics& diagnostics) {
  if (document.value(join_pointer(pointer, key))) return true;
  diagnostics.error("B010", document.origin(pointer), pointer,
                    "missing key '" + std::string(key) + "' of '" + std::string(what) + "'" +
                        (expected.empty() ? "" : ": " + std::string(expected)));
  return false;
}

}  // namespace binnacle::spec
