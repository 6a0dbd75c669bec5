// SPDX-License-Identifier: Apache-2.0
#include "observability_text.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "table.hpp"

namespace binnacle::command {

namespace {

/// A share in percent that is never rounded to all or nothing.
std::string percent(double share) {
  if (share > 0.9995 && share < 1) return "> 99.9";
  if (share > 0 && share < 0.0005) return "< 0.1";
  return fmt::format("{:.1f}", 100 * std::clamp(share, 0.0, 1.0));
}

std::string after(const Json& time) { return time.is_number() ? fmt::format("{:.4g} s", time.get<double>()) : "-"; }

/// "attitude.down 2.01 deg, gyro_bias.y -0.35 deg/h"
std::string parts_text(const Json& parts) {
  std::vector<std::string> texts;
  for (const auto& part : parts)
    texts.push_back(fmt::format("{} {} {}", part.at("component").get<std::string>(),
                                figure(part.at("displacement").get<double>()), part.at("unit").get<std::string>()));
  return joined(texts);
}

/// The measurement that removed most of a component's variance, with its share of what was removed where it is not alone.
std::string mostly_by(const Json& component) {
  const double removed = component.at("removed");
  std::string name;
  double most = 0;
  for (const auto& [measurement, share] : component.at("by").items())
    if (share.get<double>() > most) {
      most = share;
      name = measurement;
    }
  if (name.empty() || most > 0.995 * removed) return name;
  return fmt::format("{} ({} %)", name, percent(most / removed));
}

std::string components_text(const Json& components) {
  Table table("lrrlrrrl");
  table.row({"1-sigma at the start", "before", "after", "", "removed %", "without noise", "known after", "by"});
  for (const auto& [name, component] : components.items()) {
    const bool is_considered = component.value("considered", false);
    table.row({name + (is_considered ? " (considered)" : ""), figure(component.at("before").get<double>()),
               figure(component.at("after").get<double>()), component.at("unit").get<std::string>(),
               percent(component.at("removed").get<double>()),
               percent(component.at("removed_without_process_noise").get<double>()),
               after(component.at("known_after_s")), mostly_by(component)});
  }
  return table.text();
}

std::string weak_text(const Json& weak) {
  if (weak.empty()) return "  Every direction is observed: the samples remove at least half of the variance of each.\n";
  std::string text = "  Not observed (the samples remove less than half of the variance of these directions):\n";
  Table table("lrrl", 4);
  table.row({"", "removed %", "without noise", "1-sigma that remains, together"});
  for (const auto& direction : weak)
    table.row({direction.at("name").get<std::string>(), percent(direction.at("removed").get<double>()),
               percent(direction.at("removed_without_process_noise").get<double>()),
               parts_text(direction.at("parts"))});
  return text + table.text();
}

std::string inconsistent_text(const Json& window) {
  if (window.contains("not_checked"))
    return "  Consistency could not be checked: " + window.at("not_checked").get<std::string>() + ".\n";
  const Json& list = window.at("inconsistent");
  if (list.empty())
    return "  Consistent: along one path the measurements remove the variance that the filter reports.\n";
  std::string text = "  INCONSISTENT (P shrinks where the measurements along one path have no information):\n";
  Table table("lrrrl", 4);
  table.row({"", "claimed %", "seen %", "since", "1-sigma that remains, together"});
  for (const auto& direction : list)
    table.row({direction.at("name").get<std::string>(), percent(direction.at("claimed").get<double>()),
               percent(direction.at("removed").get<double>()), after(direction.at("since_s")),
               parts_text(direction.at("parts"))});
  return text + table.text();
}

std::string singular_text(const Json& values) {
  std::vector<std::string> texts;
  for (const auto& value : values) texts.push_back(fmt::format("{:.3g}", value.get<double>()));
  return "  Singular values: " + joined(texts) + "\n";
}

std::string window_text(const Json& window) {
  std::vector<std::string> samples;
  for (const auto& [name, count] : window.at("samples").items())
    samples.push_back(fmt::format("{} of {}", count.get<int>(), name));
  std::string text = fmt::format("{}: {:.9g} s to {:.9g} s; samples: {}\n\n", window.at("window").get<std::string>(),
                                 window.at("from_s").get<double>(), window.at("to_s").get<double>(), joined(samples));
  text += components_text(window.at("components")) + "\n" + weak_text(window.at("weak")) + "\n" +
          inconsistent_text(window) + singular_text(window.at("singular_values"));
  for (const auto& note : window.at("notes")) text += "  Note: " + note.get<std::string>() + ".\n";
  return text;
}

}  // namespace

std::string observability_text(const Json& filters) {
  std::string text;
  for (const auto& [name, windows] : filters.items()) {
    if (windows.empty()) text += "\nFilter " + name + " is in none of the windows.\n";
    for (const auto& window : windows) text += "\nFilter " + name + ", " + window_text(window);
  }
  return text.empty() ? "There is no filter with measurements.\n" : text.substr(1);
}

}  // namespace binnacle::command
