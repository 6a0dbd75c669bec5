// SPDX-License-Identifier: Apache-2.0
// Reading the values that the kernel itself takes from a config.
#include <algorithm>

#include "config/pointer.hpp"
#include "spec/check.hpp"
#include "spec/spec_text.hpp"

namespace binnacle::spec {

using Json = nlohmann::ordered_json;

namespace {

std::string last_token(const std::string& pointer) {
  const auto tokens = config::split_pointer(pointer);
  return tokens && !tokens->empty() ? tokens->back() : pointer;
}

ParameterValue checked(ParameterSpec spec, ParameterType type, const Document& document, const std::string& pointer,
                       Diagnostics& diagnostics) {
  spec.type = type;
  if (spec.name.empty()) spec.name = last_token(pointer);
  return check_value(spec, document, pointer, {}, diagnostics);
}

bool is_there(const ParameterValue& value) { return value.type != ParameterValue::Type::absent; }

}  // namespace

const Json* value_at(const Document& document, std::string_view pointer) {
  const auto tokens = config::split_pointer(pointer);
  if (!tokens) return nullptr;
  const Json* json = &document.root();
  for (const std::string& token : *tokens) {
    if (json->is_object()) {
      const auto found = json->find(token);
      if (found == json->end()) return nullptr;
      json = &*found;
    } else if (json->is_array()) {
      const bool is_index = !token.empty() && token.size() < 10 &&
                            std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; });
      if (!is_index || std::stoul(token) >= json->size()) return nullptr;
      json = &(*json)[std::stoul(token)];
    } else {
      return nullptr;
    }
  }
  return json;
}

std::optional<double> read_quantity(const Document& document, const std::string& pointer, const ParameterSpec& spec,
                                    Diagnostics& diagnostics) {
  const ParameterValue value = checked(spec, ParameterType::number, document, pointer, diagnostics);
  return is_there(value) ? std::optional(value.number) : std::nullopt;
}

std::optional<double> read_quantity(const Document& document, const std::string& pointer, std::string_view si_unit_text,
                                    Diagnostics& diagnostics) {
  return read_quantity(document, pointer, parameter::number("", std::string(si_unit_text)), diagnostics);
}

std::optional<std::vector<double>> read_quantities(const Document& document, const std::string& pointer,
                                                   const ParameterSpec& spec, int n, Diagnostics& diagnostics) {
  ParameterSpec sized = spec;
  sized.size = n;
  sized.size_of_port.clear();
  ParameterValue value = checked(std::move(sized), ParameterType::vector, document, pointer, diagnostics);
  return is_there(value) ? std::optional(std::move(value.numbers)) : std::nullopt;
}

std::optional<std::int64_t> read_integer(const Document& document, const std::string& pointer,
                                         const ParameterSpec& spec, Diagnostics& diagnostics) {
  const ParameterValue value = checked(spec, ParameterType::integer, document, pointer, diagnostics);
  return is_there(value) ? std::optional(value.integer) : std::nullopt;
}

std::optional<Time> read_time(const Document& document, const std::string& pointer, const ParameterSpec& spec,
                              Diagnostics& diagnostics) {
  ParameterSpec time = spec;
  time.unit = "s";
  const ParameterValue value = checked(std::move(time), ParameterType::time, document, pointer, diagnostics);
  return is_there(value) ? std::optional(value.integer) : std::nullopt;
}

std::optional<Time> read_time(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  return read_time(document, pointer, parameter::time(""), diagnostics);
}

std::optional<std::string> read_string(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  ParameterValue value = checked(parameter::text(""), ParameterType::text, document, pointer, diagnostics);
  return is_there(value) ? std::optional(std::move(value.text)) : std::nullopt;
}

std::optional<std::string> read_choice(const Document& document, const std::string& pointer,
                                       std::vector<std::string> choices, Diagnostics& diagnostics) {
  ParameterValue value =
      checked(parameter::choice("", std::move(choices)), ParameterType::choice, document, pointer, diagnostics);
  return is_there(value) ? std::optional(std::move(value.text)) : std::nullopt;
}

std::optional<std::string> read_path(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  ParameterValue value = checked(parameter::path(""), ParameterType::path, document, pointer, diagnostics);
  return is_there(value) ? std::optional(std::move(value.text)) : std::nullopt;
}

std::optional<bool> read_bool(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  const ParameterValue value = checked(parameter::boolean(""), ParameterType::boolean, document, pointer, diagnostics);
  return is_there(value) ? std::optional(value.boolean) : std::nullopt;
}

std::optional<std::vector<std::string>> read_names(const Document& document, const std::string& pointer,
                                                   Diagnostics& diagnostics) {
  const Json* json = value_at(document, pointer);
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

std::string_view without_spaces_before(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text;
}

}  // namespace

std::optional<When> read_when(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  constexpr std::string_view start = "start";
  const Json* json = value_at(document, pointer);
  if (!json) return std::nullopt;
  if (json->is_number()) {
    if (std::abs(json->get<double>()) < 9.2e9) return When{from_seconds(json->get<double>()), false};
    return refuse_when(document, pointer, json->dump() + " s is beyond 292 years", diagnostics);
  }
  if (!json->is_string()) return refuse_when(document, pointer, abbreviated(*json) + " is no time", diagnostics);
  const auto& written = json->get_ref<const std::string&>();
  std::string_view text = without_spaces_before(written);
  When when;
  when.from_start = text.starts_with(start);
  if (when.from_start) {
    text = without_spaces_before(text.substr(start.size()));
    if (text.empty()) return when;
    if (text.front() != '+' && text.front() != '-')
      return refuse_when(document, pointer, "'" + written + "' is no time", diagnostics);
  }
  const bool is_negative = text.starts_with('-');
  if (is_negative || text.starts_with('+')) text = without_spaces_before(text.substr(1));
  const Parsed<std::int64_t> time = parse_time(text);
  if (!time) return refuse_when(document, pointer, time.error(), diagnostics);
  when.time = is_negative ? -*time : *time;
  return when;
}

std::optional<Window> read_window(const Document& document, const std::string& pointer, Diagnostics& diagnostics) {
  const Json* json = value_at(document, pointer);
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

const Json* object_at(const Document& document, const std::string& pointer, std::string_view what,
                      Diagnostics& diagnostics) {
  const Json* json = value_at(document, pointer);
  if (!json || json->is_object()) return json;
  diagnostics.error("B006", document.origin(pointer), pointer,
                    std::string(what) + " must be an object; found " + abbreviated(*json));
  return nullptr;
}

const Json* array_at(const Document& document, const std::string& pointer, std::string_view what,
                     Diagnostics& diagnostics) {
  const Json* json = value_at(document, pointer);
  if (!json || json->is_array()) return json;
  diagnostics.error("B006", document.origin(pointer), pointer,
                    std::string(what) + " must be a list; found " + abbreviated(*json));
  return nullptr;
}

bool require_key(const Document& document, const std::string& pointer, std::string_view key, std::string_view what,
                 std::string_view expected, Diagnostics& diagnostics) {
  if (value_at(document, join_pointer(pointer, key))) return true;
  diagnostics.error("B010", document.origin(pointer), pointer,
                    "missing key '" + std::string(key) + "' of '" + std::string(what) + "'" +
                        (expected.empty() ? "" : ": " + std::string(expected)));
  return false;
}

}  // namespace binnacle::spec
