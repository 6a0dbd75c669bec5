// SPDX-License-Identifier: Apache-2.0
#include "summary_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "binnacle/state_block.hpp"
#include "score/run.hpp"
#include "table.hpp"

namespace binnacle::command {

namespace {

using Names = std::vector<std::string>;

double number_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string count_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->dump() : "-";
}

Names names_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? found->get<Names>() : Names();
}

/// "position.horizontal" for every norm of every block.
std::set<std::string> norms_of(const FilterInfo& filter) {
  std::set<std::string> names;
  for (const auto& block : filter.blocks)
    for (const auto& norm : block.declaration->norms) names.insert(block.name + "." + norm.name);
  return names;
}

std::string block_of(const std::string& name) { return name.substr(0, name.rfind('.')); }

/// Each block's norms before its components; blocks in the order in which they come.
Names norms_first(const Json& figures, const std::set<std::string>& norms) {
  Names blocks, names;
  for (const auto& [name, entry] : figures.items())
    if (std::find(blocks.begin(), blocks.end(), block_of(name)) == blocks.end()) blocks.push_back(block_of(name));
  for (const auto& block : blocks)
    for (const bool is_norm : {true, false})
      for (const auto& [name, entry] : figures.items())
        if (block_of(name) == block && norms.contains(name) == is_norm) names.push_back(name);
  return names;
}

std::string error_table(const std::string& title, const Json& figures, const std::set<std::string>& norms) {
  if (figures.empty()) return {};
  Table table("lrrrrrl");
  table.row({title, "rms", "p50", "p95", "max", "final", "unit"});
  for (const auto& name : norms_first(figures, norms)) {
    const Json& entry = figures.at(name);
    Names row{name};
    for (const char* key : {"rms", "p50", "p95", "max", "final"}) row.push_back(figure(number_at(entry, key)));
    row.push_back(entry.value("unit", ""));
    table.row(std::move(row));
  }
  return "\n" + table.text();
}

// ---- windows

/// What stands in the windows' table: of each block the norms, or all components where none of its norms is scored.
Names window_names(const Json& windows, const std::set<std::string>& norms) {
  Names names;
  std::set<std::string> with_norm;
  for (const auto& [window, figures] : windows.items())
    for (const auto& name : norms_first(figures, norms)) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      if (norms.contains(name)) with_norm.insert(block_of(name));
    }
  std::erase_if(names, [&](const auto& name) { return with_norm.contains(block_of(name)) && !norms.contains(name); });
  return names;
}

struct Column {
  std::string name;
  const char* key;
  std::vector<double> magnitudes;  // of the windows in which it was scored
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

void add_window_rows(const Json& windows, std::vector<Column>& columns, Table& table) {
  for (const auto& [window, figures] : windows.items()) {
    Names row{window};
    for (auto& column : columns) {
      const auto found = figures.find(column.name);
      const double value =
          found == figures.end() ? std::numeric_limits<double>::quiet_NaN() : number_at(*found, column.key);
      row.push_back(figure(value));
      if (!std::isnan(value)) column.magnitudes.push_back(std::abs(value));
    }
    table.row(std::move(row));
  }
}

void add_across_row(const std::string& title, const std::vector<Column>& columns,
                    double (*statistic)(const std::vector<double>&), Table& table) {
  Names row{title};
  for (const auto& column : columns)
    row.push_back(column.magnitudes.empty() ? "-" : figure(statistic(column.magnitudes)));
  table.row(std::move(row));
}

std::string unit_in(const Json& windows, const std::string& name) {
  for (const auto& [window, figures] : windows.items())
    if (figures.contains(name)) return figures.at(name).value("unit", "");
  return {};
}

std::string window_table(const Json& windows, const std::set<std::string>& norms) {
  const Names names = window_names(windows, norms);
  if (names.empty()) return {};
  std::vector<Column> columns;
  Names heads{""}, subheads{"window"};
  for (const auto& name : names) {
    heads.insert(heads.end(), {name, fmt::format("[{}]", unit_in(windows, name))});
    for (const char* key : {"final", "rms"}) {
      subheads.push_back(key);
      columns.push_back({name, key, {}});
    }
  }
  Table table("l" + std::string(columns.size(), 'r'));
  table.row(std::move(heads));
  table.row(std::move(subheads));
  add_window_rows(windows, columns, table);
  if (windows.size() > 1) {
    add_across_row(fmt::format("over {} windows: mean", windows.size()), columns, mean, table);
    add_across_row(
        "median", columns, [](const std::vector<double>& values) { return median(values); }, table);
    add_across_row("max", columns, largest, table);
  }
  return "\n" + table.text();
}

/// Over the windows of all filters: what the summary has under "windows".
std::string across_table(const Json& across) {
  Table table("lrrrrrrrl");
  table.row({"", "", "final", "", "", "rms", "", "", ""});
  table.row({"over all filters", "windows", "mean", "median", "max", "mean", "median", "max", "unit"});
  for (const auto& [name, entry] : across.items()) {
    Names row{name, count_at(entry, "n")};
    for (const char* key : {"final", "rms"})
      for (const char* statistic : {"mean", "p50", "max"}) row.push_back(figure(number_at(entry.at(key), statistic)));
    row.push_back(entry.value("unit", ""));
    table.row(std::move(row));
  }
  return table.text() + "\n";
}

// ---- measurements, consistency

/// Innovations of each row, and the standard deviation that would make them consistent.
std::string innovation_table(const Json& measurements) {
  Table table("lrrrrrrrl");
  table.row({"innovations", "used", "refused", "mean/S", "RMS/S", "lag 1", "sigma", "fitting", "unit"});
  constexpr std::size_t most = 12;
  bool is_empty = true;
  for (const auto& [name, entry] : measurements.items()) {
    if (!entry.contains("innovations") || entry["innovations"].size() > most) continue;
    for (const auto& row : entry["innovations"]) {
      is_empty = false;
      table.row(
          {fmt::format("{} {} {}", name, row["part"] == name ? "" : row["part"].get<std::string>(), row["row"].dump()),
           count_at(row, "used"), count_at(row, "refused"), figure(number_at(row, "mean")),
           figure(number_at(row, "rms")), figure(number_at(row, "correlation")), figure(number_at(row, "sigma")),
           figure(number_at(row, "fitting_sigma")), row["unit"].get<std::string>()});
    }
  }
  return is_empty ? "" : "\n" + table.text();
}

std::string measurement_table(const Json& measurements) {
  if (measurements.empty()) return {};
  constexpr const char* counts[] = {"offered", "accepted", "gated",    "late",        "unsupported",
                                    "invalid", "rejected", "withheld", "before_start"};
  Table table("lrrrrrrrrrr");
  Names heads{"measurement"};
  for (const char* key : counts) heads.push_back(key == std::string("before_start") ? "before start" : key);
  heads.push_back("NIS / dof");
  table.row(std::move(heads));
  std::string reasons;
  for (const auto& [name, entry] : measurements.items()) {
    Names row{name};
    for (const char* key : counts) row.push_back(count_at(entry, key));
    row.push_back(fmt::format("{} / {:.4g}", figure(number_at(entry, "nis_mean")), number_at(entry, "dof")));
    table.row(std::move(row));
    if (entry.contains("recoveries") && entry["recoveries"] != 0)
      reasons += fmt::format("  {}: reopened {}\n", name, counted(entry["recoveries"], "time"));
    if (entry.contains("left_out") && entry["left_out"]["rows"] != 0) {
      Names keys;
      for (const auto& [key, count] : entry["left_out"]["by_key"].items())
        keys.push_back(fmt::format("{} ({})", key, count.dump()));
      reasons += fmt::format("  {}: {} of {} rows left out, which (times): {}\n", name,
                             entry["left_out"]["rows"].dump(), entry["left_out"]["of"].dump(), fmt::join(keys, ", "));
    }
    if (entry.contains("iterated") && entry["iterated"]["samples"] != 0) {
      const auto& iterated = entry["iterated"];
      const double samples = iterated["samples"].get<double>();
      reasons += fmt::format("  {}: iterated, {:.3g} linearizations per sample; {} of {} did not converge\n", name,
                             number_at(iterated, "linearizations") / samples, iterated["not_converged"].dump(),
                             counted(iterated["samples"], "sample"));
    }
    if (entry.contains("linearized_instead") && entry["linearized_instead"] != 0)
      reasons += fmt::format("  {}: {} linearized, a sigma point was refused\n", name,
                             counted(entry["linearized_instead"], "sample"));
    if (entry.contains("replayed"))
      reasons += fmt::format("  {}: {} came late, by up to {:.3g} s, and were applied at their time\n", name,
                             counted(entry["replayed"], "sample"), number_at(entry, "longest_delay_s"));
    if (entry.contains("last_reason"))
      reasons += fmt::format("  {}: last refused because {}\n", name, entry["last_reason"].get<std::string>());
  }
  return "\n" + table.text() + reasons;
}

std::string consistency_table(const Json& consistency) {
  Table table("lrrr");
  table.row({"block", "NEES", "dof", "n"});
  const auto add = [&](const std::string& name, const Json& entry) {
    table.row({name, figure(number_at(entry, "nees_mean")), fmt::format("{:.4g}", number_at(entry, "dof")),
               count_at(entry, "n")});
  };
  for (const auto& [name, entry] : consistency.items()) {
    add(name, entry);
    if (entry.contains("windows"))
      for (const auto& [window, inside] : entry["windows"].items()) add(name + " in " + window, inside);
  }
  std::string text = "\n" + table.text();
  for (const auto& [name, entry] : consistency.items())
    if (const auto without = names_at(entry, "without"); !without.empty())
      text += fmt::format("  {}: of {} together; no reference gives all of {}\n", name,
                          fmt::join(names_at(entry, "blocks"), ", "), fmt::join(without, ", "));
  return text;
}

/// Blocks without any reference: what the filter itself makes of their errors.
std::string unscored_table(const Json& unscored) {
  Table table("lrl");
  table.row({"without reference", "sigma at the end", "unit"});
  for (const auto& [name, entry] : unscored.items())
    table.row({name, figure(number_at(entry, "sigma")), entry.value("unit", "")});
  return "\n" + table.text();
}

/// What the verdict says besides.
Json notes_of(const Json& verdict) {
  const auto found = verdict.find("notes");
  return found == verdict.end() ? Json::array() : *found;
}

std::string notes_text(const Json& filter) {
  std::string text;
  if (filter.contains("notes"))
    for (const auto& note : filter.at("notes")) text += fmt::format("  note: {}\n", note.get<std::string>());
  if (filter.contains("verdict"))
    for (const auto& note : notes_of(filter.at("verdict")))
      text += fmt::format("  note: {} {}\n", note.at("code").get<std::string>(), note.at("text").get<std::string>());
  return text;
}

// ---- a filter

/// Where a filter is scored against withheld samples, these figures are the reference's.
bool is_part_of(const Json& figures, const Json& reference) {
  for (const auto& [name, entry] : figures.items())
    if (!reference.contains(name) || reference.at(name) != entry) return false;
  return true;
}

/// ", 3 iterations, converged (last change 0.0002 sigma)"; ", 5 s, swept every 1 s".
std::string smoother_text(const Json& smoother) {
  if (smoother.contains("lag_s"))
    return fmt::format(", {} s, swept every {} s", number_at(smoother, "lag_s"), number_at(smoother, "every_s"));
  if (!smoother.contains("iterations")) return "";
  std::string text = ", " + counted(smoother.at("iterations"), "iteration");
  if (smoother.contains("change"))
    text += fmt::format(", {} (last change {:.2g} sigma)",
                        smoother.at("converged").get<bool>() ? "converged" : "not converged",
                        number_at(smoother, "change"));
  if (smoother.contains("reason")) text += ": " + smoother.at("reason").get<std::string>();
  return text;
}

/// Before its start a filter has no estimate, and neither has its smoother.
std::string wait_text(const Json& filter) {
  if (!filter.contains("waited")) return "";
  const Json& waited = filter.at("waited");
  return fmt::format("  first estimate at {:.3f} s, {:.1f} s after the data begin: it waited for {}\n",
                     number_at(filter, "start_s"), number_at(waited, "seconds"),
                     names_at(waited, "for").empty() ? "its driving input"
                                                     : fmt::format("{}", fmt::join(names_at(waited, "for"), ", ")));
}

std::string heading(const std::string& name, const Json& filter) {
  if (filter.contains("smoother")) {
    const auto& smoother = filter.at("smoother");
    const std::string type = smoother.at("type").get<std::string>();
    const double breaks = number_at(smoother, "breaks");
    return fmt::format("{}: {}{}{}; the verdict is that of {}\n", name, type,
                       breaks > 0 ? fmt::format(", began anew {}", counted(smoother.at("breaks"), "time")) : "",
                       smoother_text(smoother), smoother.at("of").get<std::string>());
  }
  std::string text = name + ": never started";
  if (filter.contains("start_s"))
    text = fmt::format("{}: {:.3f} s to {:.3f} s", name, number_at(filter, "start_s"), number_at(filter, "end_s"));
  const double steps = number_at(filter, "steps"), filter_s = number_at(filter, "filter_s");
  text += fmt::format(", {} steps", count_at(filter, "steps"));
  if (steps > 0) text += fmt::format(", {} per step", duration(filter_s / steps));
  if (filter.contains("longest_lag_s"))
    text += fmt::format(", live estimates up to {:.3g} s behind", number_at(filter, "longest_lag_s"));
  if (filter.contains("input_gaps")) text += fmt::format(", {} gaps in its input", count_at(filter, "input_gaps"));
  return text + (filter.contains("broken") ? "; BROKEN\n" : "\n") + wait_text(filter);
}

std::string filter_text(const std::string& name, const Json& filter, const FilterInfo& info) {
  const auto norms = norms_of(info);
  std::string text = heading(name, filter);
  text += error_table("error", filter.at("reference"), norms);
  if (filter.contains("withheld"))
    for (const auto& [measurement, figures] : filter.at("withheld").items())
      if (!is_part_of(figures, filter.at("reference")))
        text += error_table(fmt::format("withheld '{}'", measurement), figures, norms);
  if (filter.contains("unscored")) text += unscored_table(filter.at("unscored"));
  if (filter.contains("windows")) text += window_table(filter.at("windows"), norms);
  if (filter.contains("consistency")) text += consistency_table(filter.at("consistency"));
  if (!filter.contains("measurements")) return text;  // of a smoothed filter: they are the filter's
  text += measurement_table(filter.at("measurements"));
  text += notes_text(filter);
  return text + innovation_table(filter.at("measurements"));
}

/// What "evaluate" asks for besides: of segments it stands nowhere else.
std::string metric_table(const Json& metrics) {
  Table table("lrl");
  table.row({"metric", "value", "unit"});
  for (const auto& [name, entry] : metrics.items())
    table.row({name, figure(number_at(entry, "value")), entry.value("unit", "")});
  return table.text() + "\n";
}

/// Of a run that goes by the clock.
std::string live_text(const Json& live) {
  Table table("lrrrrr");
  table.row({"arrived", "samples", "behind", "latency p50", "p99", "max"});
  const auto time = [](const Json& figures, const char* key) { return duration(number_at(figures, key)); };
  double samples = 0;
  for (const auto& [name, figures] : live.at("channels").items()) {
    samples += number_at(figures, "samples");
    table.row({name, count_at(figures, "samples"), count_at(figures, "behind"), time(figures, "latency_p50_s"),
               time(figures, "latency_p99_s"), time(figures, "latency_max_s")});
  }
  std::string text = "\n" + table.text();
  for (const auto& [name, figures] : live.at("sources").items())
    text += fmt::format("  {}: at most {} waiting, {} lost, {} unusable\n", name, count_at(figures, "longest_queue"),
                        count_at(figures, "lost"), count_at(figures, "unusable"));
  const double seconds = number_at(live, "seconds");
  return text + fmt::format("  {:.0f} samples in {}\n\n", samples, duration(seconds));
}

/// "ok", or "ok (not watched: zupt; conservative: fix)".
std::string verdict_text(const Json& verdict) {
  Names besides;
  if (const auto unwatched = verdict.find("unwatched"); unwatched != verdict.end())
    besides.push_back(fmt::format("not watched: {}", fmt::join(unwatched->get<Names>(), ", ")));
  Names conservative;
  for (const auto& note : notes_of(verdict))  // where errors persist, the filter may be right
    if (note.value("likely", "persisting_errors") != "persisting_errors")
      conservative.push_back(note.at("measurement").get<std::string>());
  if (!conservative.empty()) besides.push_back(fmt::format("conservative: {}", fmt::join(conservative, ", ")));
  const std::string state = verdict.at("state").get<std::string>();
  return besides.empty() ? state : fmt::format("{} ({})", state, fmt::join(besides, "; "));
}

}  // namespace

std::string summary_text(const Json& summary, const Composition& composition) {
  std::string text = heading(composition.title());
  for (const auto& filter : score::filters_of(composition))
    text += filter_text(filter.name, summary.at("filters").at(filter.name), filter) + "\n";
  if (composition.filters().size() > 1 && summary.contains("windows")) text += across_table(summary.at("windows"));
  if (summary.contains("metrics")) text += metric_table(summary.at("metrics"));
  if (summary.contains("live")) text += live_text(summary.at("live"));
  text += fmt::format("wall time {}\nverdict:", duration(number_at(summary, "wall_s")));
  for (const auto& [name, filter] : summary.at("filters").items())
    if (filter.contains("verdict")) text += " " + name + " " + verdict_text(filter.at("verdict"));
  return text + "\n";
}

}  // namespace binnacle::command
