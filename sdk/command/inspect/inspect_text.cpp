// SPDX-License-Identifier: Apache-2.0
#include "inspect_text.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "table.hpp"

namespace binnacle::command {

namespace {

using inspect::Finding;
using inspect::Severity;

void write_channels(const inspect::Inspection& inspection, std::string& text) {
  Table table("llrl");
  for (const auto& channel : inspection.channels) {
    std::string fields;
    for (const auto& field : channel.fields)
      fields += (fields.empty() ? "" : ", ") + field.name +
                (field.unit.empty() ? " [?]" : fmt::format(" [{}{}]", field.unit, field.is_guessed ? "?" : ""));
    table.row({channel.name, channel.path.empty() ? channel.type : channel.path, counted(channel.t.size(), "sample"),
               fields});
  }
  text += table.text();
}

void write_one(const Finding& found, bool with_evidence, std::string& text) {
  text += fmt::format("  {:<18} {}{}\n", found.kind, found.field.empty() ? "" : found.field + ": ", found.text);
  if (!with_evidence) return;
  text += fmt::format("  {:<18} seen by: {}\n", "", found.evidence);
  if (!found.meaning.is_null()) text += fmt::format("  {:<18} config: {}\n", "", found.meaning.dump());
}

}  // namespace

std::string inspection_text(const inspect::Inspection& inspection) {
  std::string text;
  write_channels(inspection, text);
  const auto count = std::ranges::count_if(inspection.findings,
                                           [](const Finding& found) { return found.severity == Severity::warning; });
  text += count == 0 ? "\nNo warnings\n" : fmt::format("\n{}\n", counted(static_cast<std::size_t>(count), "warning"));
  for (const Finding& found : inspection.findings)
    if (found.severity == Severity::warning) {
      text += fmt::format(" {}\n", found.channel);
      write_one(found, true, text);
    }
  std::vector<std::string> names;
  for (const Finding& found : inspection.findings)
    if (found.severity == Severity::finding && std::ranges::find(names, found.channel) == names.end())
      names.push_back(found.channel);
  for (const auto& name : names) {
    text += fmt::format("\n{}\n", name);
    for (const Finding& found : inspection.findings)
      if (found.severity == Severity::finding && found.channel == name)
        write_one(found, !found.meaning.is_null(), text);
  }
  bool has_title = false;
  for (const Finding& found : inspection.findings) {
    if (found.severity != Severity::unknown) continue;
    if (!has_title) text += "\nNot determined by these data\n";
    has_title = true;
    write_one(found, false, text);
  }
  text += "\nNoise of a sensor: binnacle allan\n";
  return text;
}

}  // namespace binnacle::command
