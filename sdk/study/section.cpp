// SPDX-License-Identifier: Apache-2.0
#include "study/section.hpp"

#include <algorithm>

#include "wording/wording.hpp"

namespace binnacle::study {

using namespace wording;

namespace {

std::string last_token(const std::string& pointer) { return pointer.substr(pointer.rfind('/') + 1); }

std::string found(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list";
  std::string text = value.dump();
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  return (value.is_string() ? "the text " : value.is_number() ? "the number " : "") + text;
}

}  // namespace

void Section::error(const std::string& code, const std::string& pointer, const std::string& message) const {
  diagnostics_.error(code, config_.origin(pointer), pointer, message);
}

void Section::key_error(const std::string& code, const std::string& pointer, const std::string& message) const {
  diagnostics_.error(code, config_.key_origin(pointer), pointer, message);
}

void Section::wrong_type(const std::string& pointer, const char* wanted) const {
  error("B006", pointer, in_quotes(last_token(pointer)) + " is " + wanted + "; found " + found(*at(pointer)));
}

const Json* Section::at(const std::string& pointer) const {
  const Json::json_pointer where(pointer);
  return root_.contains(where) ? &root_.at(where) : nullptr;
}

void Section::check_keys(const std::string& pointer, const std::vector<std::string>& allowed,
                         std::string_view what) const {
  for (const auto& [key, value] : at(pointer)->items())
    if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
      key_error("B012", join_pointer(pointer, key),
                "unknown key of " + std::string(what) + suggestion(key, allowed) + " (keys: " + listed(allowed) + ")");
}

const Json* Section::object(const std::string& pointer) const {
  const Json* value = at(pointer);
  if (!value || value->is_object()) return value;
  wrong_type(pointer, "an object");
  return nullptr;
}

const Json* Section::list(const std::string& pointer) const {
  const Json* value = at(pointer);
  if (!value || value->is_array()) return value;
  wrong_type(pointer, "a list");
  return nullptr;
}

std::optional<std::string> Section::text(const std::string& pointer) const {
  const Json* value = at(pointer);
  if (!value) return std::nullopt;
  if (value->is_string()) return value->get<std::string>();
  wrong_type(pointer, "a text");
  return std::nullopt;
}

std::optional<bool> Section::truth(const std::string& pointer) const {
  const Json* value = at(pointer);
  if (!value) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  wrong_type(pointer, "true or false");
  return std::nullopt;
}

std::optional<std::int64_t> Section::whole_number(const std::string& pointer, std::int64_t least) const {
  const Json* value = at(pointer);
  if (!value) return std::nullopt;
  if (!value->is_number_integer()) {
    wrong_type(pointer, "a whole number");
    return std::nullopt;
  }
  const auto number = value->get<std::int64_t>();
  if (number >= least) return number;
  error("B009", pointer,
        in_quotes(last_token(pointer)) + " is at least " + std::to_string(least) + "; found " + value->dump());
  return std::nullopt;
}

std::optional<std::string> Section::choice(const std::string& pointer, const std::vector<std::string>& choices) const {
  const auto word = text(pointer);
  if (!word || std::find(choices.begin(), choices.end(), *word) != choices.end()) return word;
  error("B014", pointer,
        in_quotes(last_token(pointer)) + " is not " + in_quotes(*word) + suggestion(*word, choices) + " (one of " +
            listed(choices) + ")");
  return std::nullopt;
}

}  // namespace binnacle::study
