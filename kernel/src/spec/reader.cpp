// SPDX-License-Identifier: Apache-2.0
// Reading places of a config: what stands there, and the values that the kernel itself takes.
#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "base/time_range.hpp"
#include "config/node.hpp"
#include "spec/check.hpp"

namespace binnacle {

using namespace internal;
using config::JsonOf;

Reader::Reader(const config::Document& document, Diagnostics& diagnostics, const std::string& pointer)
    : document_(&document), diagnostics_(&diagnostics), pointer_(pointer), json_(document.value(pointer)) {
  const auto tokens = config::split_pointer(pointer);
  key_ = tokens && !tokens->empty() ? tokens->back() : pointer;
}

Reader Reader::operator[](std::string_view key) const {
  Reader member = *this;
  member.key_ = key;
  if (!is_default_) member.pointer_ = join_pointer(pointer_, key);
  member.json_ = nullptr;
  if (!is_object()) return member;
  const spec::Json& object = JsonOf::at(*this);
  constexpr std::size_t many = 32;
  if (object.size() > many && !is_default_) {  // found without a search
    member.json_ = document_->value(member.pointer_);
  } else if (const auto found = object.find(member.key_); found != object.end()) {
    member.json_ = &*found;
  }
  return member;
}

std::vector<Reader> Reader::children() const {
  std::vector<Reader> all;
  if (!json_ || !JsonOf::at(*this).is_structured()) return all;
  for (const auto& item : JsonOf::at(*this).items()) {
    Reader& child = all.emplace_back(*this);
    child.key_ = item.key();
    if (!is_default_) child.pointer_ = join_pointer(pointer_, child.key_);
    child.json_ = &item.value();
  }
  return all;
}

Origin Reader::origin() const { return document_->origin(pointer_); }
Origin Reader::key_origin() const { return document_->key_origin(pointer_); }
std::filesystem::path Reader::folder() const { return document_->base_dir(pointer_); }

void Reader::error(const std::string& code, const std::string& message) const {
  diagnostics_->error(code, origin(), pointer_, message);
}
void Reader::warning(const std::string& code, const std::string& message) const {
  diagnostics_->warning(code, origin(), pointer_, message);
}
void Reader::key_error(const std::string& code, const std::string& message) const {
  diagnostics_->error(code, key_origin(), pointer_, message);
}

bool Reader::is_object(std::string_view what) const {
  const bool is_it = json_ && JsonOf::at(*this).is_object();
  if (json_ && !is_it && !what.empty()) error("B006", std::string(what) + " must be an object; found " + shown());
  return is_it;
}

bool Reader::is_list(std::string_view what) const {
  const bool is_it = json_ && JsonOf::at(*this).is_array();
  if (json_ && !is_it && !what.empty()) error("B006", std::string(what) + " must be a list; found " + shown());
  return is_it;
}

std::vector<Reader> Reader::members(std::string_view what) const {
  return is_object(what) ? children() : std::vector<Reader>();
}
std::vector<Reader> Reader::elements(std::string_view what) const {
  return is_list(what) ? children() : std::vector<Reader>();
}

std::set<std::string> Reader::check_keys(const std::vector<std::string>& allowed, std::string_view what,
                                         const RenamedKeys& renamed,
                                         const std::map<std::string, std::string>& detail) const {
  constexpr std::size_t most = 16;
  std::set<std::string> meant;
  if (!is_object()) return meant;
  for (const Reader& member : children()) {
    const std::string& key = member.key();
    if (std::ranges::find(allowed, key) != allowed.end()) continue;
    const auto former = std::ranges::find(renamed, key, &RenamedKeys::value_type::first);
    const std::string near = former != renamed.end() ? former->second : closest(key, allowed);
    std::string hint;
    if (former != renamed.end())
      hint = "; " + base::in_quotes(key) + " is now called " + base::in_quotes(near);
    else if (!near.empty())
      hint = "; did you mean " + base::in_quotes(near) + (detail.contains(near) ? detail.at(near) : "") + "?";
    else if (allowed.size() <= most)
      hint = allowed.empty() ? "; it takes none" : "; it takes " + base::quoted_list(allowed);
    member.key_error("B012", "unknown key of " + std::string(what) + hint);
    if (!near.empty()) meant.insert(near);
  }
  return meant;
}

bool Reader::require(std::string_view key, std::string_view what, std::string_view expected) const {
  if ((*this)[key]) return true;
  error("B010", "missing key " + base::in_quotes(key) + " of " + base::in_quotes(what) +
                    (expected.empty() ? "" : ": " + std::string(expected)));
  return false;
}

namespace {

template <class T>
std::optional<T> read(const Reader& at, ParameterSpec spec, ParameterType type, T ParameterValue::*member) {
  spec.type = type;
  if (spec.name.empty()) spec.name = at.key();
  const ParameterValue found = at.value(spec);
  return found.type == ParameterValue::Type::absent ? std::nullopt : std::optional<T>(found.*member);
}

/// Without the prefix, if it is there, and spaces around.
bool take(std::string_view& text, std::string_view prefix) {
  const bool is_there = text.starts_with(prefix);
  if (is_there) text.remove_prefix(prefix.size());
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return is_there;
}

}  // namespace

std::optional<double> Reader::number(const ParameterSpec& spec) const {
  return read(*this, spec, ParameterType::number, &ParameterValue::number);
}
std::optional<std::int64_t> Reader::integer(const ParameterSpec& spec) const {
  return read(*this, spec, ParameterType::integer, &ParameterValue::integer);
}
std::optional<std::string> Reader::text() const { return read(*this, {}, ParameterType::text, &ParameterValue::text); }
std::optional<std::string> Reader::path() const { return read(*this, {}, ParameterType::path, &ParameterValue::text); }
std::optional<bool> Reader::boolean() const {
  return read(*this, {}, ParameterType::boolean, &ParameterValue::boolean);
}
std::optional<Time> Reader::time(const ParameterSpec& spec) const {
  return read(*this, spec, ParameterType::time, &ParameterValue::integer);
}

std::optional<std::vector<std::string>> Reader::names() const {
  if (!json_) return std::nullopt;
  const spec::Json& json = JsonOf::at(*this);
  if (json.is_string()) return std::vector<std::string>{json.get<std::string>()};
  if (json.is_array() && std::ranges::all_of(json, [](const auto& item) { return item.is_string(); }))
    return json.get<std::vector<std::string>>();
  error("B006", base::in_quotes(key_) + " must be a name or a list of names; found " + shown());
  return std::nullopt;
}

std::optional<When> Reader::when() const {
  if (!json_) return std::nullopt;
  const spec::Json& json = JsonOf::at(*this);
  const auto refuse = [&](const std::string& why) {
    error("B024", why + "; write \"228 s\" or \"start+60 s\"");
    return std::nullopt;
  };
  if (json.is_number()) {
    if (std::abs(json.get<double>()) <= seconds(base::farthest_time))
      return When{from_seconds(json.get<double>()), false};
    return refuse(json.dump() + " s is beyond " + base::farthest_text);
  }
  if (!json.is_string()) return refuse(shown() + " is not a time");
  std::string_view text = json.get_ref<const std::string&>();
  take(text, "");
  When when;
  when.from_start = take(text, "start");
  if (when.from_start && text.empty()) return when;
  const bool is_negative = take(text, "-");
  if (!is_negative && !take(text, "+") && when.from_start)
    return refuse(base::in_quotes(json.get<std::string>()) + " is not a time");
  const Parsed<std::int64_t> time = parse_time(text);
  if (!time) return refuse(time.error());
  when.time = is_negative ? -*time : *time;
  return when;
}

std::optional<TimeSpan> Reader::span() const {
  if (!json_) return std::nullopt;
  if (!is_list() || JsonOf::at(*this).size() != 2) {
    error("B024", "a window is [from, to], for example [\"228 s\", \"258 s\"]; found " + shown());
    return std::nullopt;
  }
  const std::vector<Reader> ends = children();
  const auto from = ends[0].when(), to = ends[1].when();
  if (!from || !to) return std::nullopt;
  if (from->from_start == to->from_start && from->time >= to->time) {
    error("B024", "the window ends before it begins");
    return std::nullopt;
  }
  return TimeSpan{from->time, to->time, from->from_start, to->from_start};
}

}  // namespace binnacle
