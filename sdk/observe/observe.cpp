// SPDX-License-Identifier: Apache-2.0
#include "observe/observe.hpp"

#include "figures.hpp"
#include "one_path.hpp"
#include "score/sections.hpp"
#include "wording/wording.hpp"

namespace binnacle::observe {

using namespace wording;
using Json = nlohmann::ordered_json;

namespace {

/// "60", "60 s", "start", "start+10 s", "start + 10".
Parsed<When> read_time(std::string_view text) {
  using Result = Parsed<When>;
  const std::string quoted = in_quotes(text);
  const auto take = [&](std::string_view word) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    const bool is_there = text.starts_with(word);
    if (is_there) text.remove_prefix(word.size());
    return is_there;
  };
  When when;
  when.from_start = take("start");
  if (when.from_start && text.empty()) return when;
  const bool is_negative = take("-");
  if (!is_negative && !take("+") && when.from_start) return Result::failure(quoted + " is not a time");
  take("");
  const bool has_unit = text.find_first_not_of("0123456789.eE+-") != std::string_view::npos;
  const auto time = parse_time(has_unit ? std::string(text) : std::string(text) + " s");
  if (!time) return Result::failure(time.error());
  when.time = is_negative ? -*time : *time;
  return when;
}

/// FROM:TO.
Parsed<Window> read_span(const std::string& text, std::size_t colon) {
  Window window = whole_run();
  window.name = text;
  const std::string from = text.substr(0, colon), to = text.substr(colon + 1);
  if (!from.empty()) {
    const auto when = read_time(from);
    if (!when) return Parsed<Window>::failure(when.error());
    window.span.from = when->time;
    window.span.from_is_relative = when->from_start;
  }
  if (!to.empty()) {
    const auto when = read_time(to);
    if (!when) return Parsed<Window>::failure(when.error());
    window.span.to = when->time;
    window.span.to_is_relative = when->from_start;
  }
  if (window.span.from_is_relative == window.span.to_is_relative && window.span.to <= window.span.from)
    return Parsed<Window>::failure("the window " + in_quotes(text) + " ends before it begins");
  return window;
}

std::string time_text(const Json& time) { return time.is_string() ? time.get<std::string>() : time.dump(); }

}  // namespace

Window whole_run() { return {"the whole run", score::all_time}; }

Parsed<Window> read_window(const Composition& composition, const std::string& text) {
  const Json config = Json::parse(composition.config());
  const Json windows = config.value(Json::json_pointer("/evaluate/windows"), Json::object());
  if (windows.contains(text)) {
    const Json& named = windows.at(text);
    const Json& span = named.is_object() ? named.at("span") : named;
    const std::string written = time_text(span.at(0)) + ":" + time_text(span.at(1));
    const auto window = read_span(written, written.find(':'));
    return window ? Parsed<Window>({text, window->span}) : window;
  }
  if (const auto colon = text.find(':'); colon != std::string::npos) return read_span(text, colon);
  std::vector<std::string> names;
  for (const auto& [name, window] : windows.items()) names.push_back(name);
  return Parsed<Window>::failure("there is no window " + in_quotes(text) + suggestion(text, names) +
                                 " (windows of \"evaluate\": " + listed(names) +
                                 "; or FROM:TO, for example 60:90 or start+60:start+90)");
}

Observability::Observability(const Composition& composition, const std::vector<Window>& windows) {
  for (const FilterInfo& filter : composition.filters()) {
    const bool has_any = filter.dof > 0 && !filter.measurements.empty();
    watches_.push_back(has_any ? std::make_unique<FilterWatch>(filter, windows) : nullptr);
  }
}

Json Observability::figures(const std::filesystem::path& config, const LoadOptions& options, const RunKey& key) const {
  Json filters = Json::object();
  for (std::size_t f = 0; f < watches_.size(); ++f) {
    if (!watches_[f]) continue;
    const FilterInfo& info = watches_[f]->filter();
    Json& list = filters[info.name] = Json::array();
    for (const Stay& stay : watches_[f]->stays()) {
      const OnePath path = on_one_path(config, options, key, static_cast<int>(f), info, stay);
      if (!key.goes_on()) return filters;
      list.push_back(figures_of(stay, path, info));
    }
  }
  return filters;
}

}  // namespace binnacle::observe
