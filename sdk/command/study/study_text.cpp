// SPDX-License-Identifier: Apache-2.0
#include "study_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "table.hpp"

namespace binnacle::command {

namespace {

double number(const Json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

/// "3.38 ± 0.11": the error to two digits, the value to as many decimals. Without an error, four digits.
std::string with_error(double value, double se) {
  if (!std::isfinite(value) || !(se > 0)) return figure(value);
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(se)));
  if (decimals > 6 || std::abs(value) >= 1e7) return figure(value) + " ± " + figure(se);
  return fmt::format("{0:.{2}f} ± {1:.{2}f}", value, se, std::max(0, decimals));
}

bool has_figures(const Json& variants, const std::string& metric) {
  return std::any_of(variants.begin(), variants.end(),
                     [&](const Json& variant) { return variant.at("metrics").contains(metric); });
}

/// A metric over the variants.
std::string metric_text(const Json& variants, const study::StudyMetric& metric) {
  if (!has_figures(variants, metric.name)) return {};
  const bool has_band = metric.is_chi_squared;
  Table table(has_band ? "lrrrrrrl" : "lrrrrrr");
  const std::string unit = metric.unit == "1" ? "" : " [" + metric.unit + "]";
  std::vector<std::string> heads{metric.name + unit, "rms", "mean", "std", "p50", "p95", "runs"};
  if (has_band) heads.push_back("mean if consistent (99 %)");
  table.row(heads);
  for (const auto& [name, variant] : variants.items()) {
    if (!variant.at("metrics").contains(metric.name)) continue;
    const Json& entry = variant.at("metrics").at(metric.name);
    const auto at = [&entry](const char* key) { return number(entry.at(key)); };
    std::vector<std::string> row{name,
                                 with_error(at("rms"), at("se_rms")),
                                 with_error(at("mean"), at("se")),
                                 figure(at("std")),
                                 figure(at("p50")),
                                 figure(at("p95")),
                                 entry.at("n").dump()};
    if (has_band && entry.contains("band")) {
      const double low = number(entry.at("band")[0]), high = number(entry.at("band")[1]), mean = at("mean");
      row.push_back(fmt::format("{} to {}{}", figure(low), figure(high),
                                mean < low    ? ", below"
                                : mean > high ? ", above"
                                              : ""));
    }
    table.row(std::move(row));
  }
  return table.text() + "\n";
}

/// Runs that do not end `ok`, by variant; empty where there is none.
std::string verdicts_text(const Json& variants) {
  Table table("lrrr");
  table.row({"verdicts", "ok", "doubtful", "lost"});
  bool is_empty = true;
  for (const auto& [name, variant] : variants.items()) {
    const Json& counts = variant.at("verdicts");
    if (counts["doubtful"] == 0 && counts["lost"] == 0) continue;
    is_empty = false;
    table.row({name, counts["ok"].dump(), counts["doubtful"].dump(), counts["lost"].dump()});
  }
  return is_empty ? "" : table.text() + "\n";
}

/// The unit of all cells that are not empty; "" where they differ.
std::string common_unit(const Json& units, std::size_t first_column, std::size_t last_column) {
  std::string unit;
  for (const auto& row : units)
    for (std::size_t c = first_column; c < last_column; ++c) {
      const auto other = row[c].get<std::string>();
      if (unit.empty()) unit = other;
      if (other != unit && !other.empty()) return {};
    }
  return unit == "1" ? "" : unit;
}

std::string in_brackets(const std::string& unit) { return unit.empty() ? "" : "[" + unit + "]"; }

/// As the config writes it.
std::string printed(const Json& figure_of_paper) {
  return figure_of_paper.is_null() ? "-" : fmt::format("{}", figure_of_paper.get<double>());
}

bool has_paper(const Json& plan, std::size_t column) {
  return plan.contains("paper") && std::any_of(plan.at("paper").begin(), plan.at("paper").end(),
                                               [&](const Json& row) { return !row[column].is_null(); });
}

std::string table_text(const Json& plan, bool shows_errors) {
  const auto& columns = plan.at("columns");
  const std::string unit = common_unit(plan.at("units"), 0, columns.size());
  std::string alignment = "l";
  std::vector<std::string> heads{""}, subheads{""};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::string own = unit.empty() ? in_brackets(common_unit(plan.at("units"), c, c + 1)) : "";
    heads.push_back(columns[c].get<std::string>() + (own.empty() ? "" : " " + own));
    subheads.push_back("here");
    alignment += "r";
    if (!has_paper(plan, c)) continue;
    heads.push_back("");
    subheads.push_back("paper");
    alignment += "r";
  }
  Table table(alignment);
  table.row(heads);
  if (plan.contains("paper")) table.row(subheads);
  for (std::size_t r = 0; r < plan.at("rows").size(); ++r) {
    std::vector<std::string> row{plan.at("rows")[r].get<std::string>()};
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double se = shows_errors ? number(plan.at("se")[r][c]) : 0;
      const Json& cell = plan.at("cells")[r][c];
      row.push_back(cell.is_string() ? cell.get<std::string>() : with_error(number(cell), se));
      if (has_paper(plan, c)) row.push_back(printed(plan.at("paper")[r][c]));
    }
    table.row(std::move(row));
  }
  const std::string title = plan.at("title").get<std::string>();
  const std::string head = title + (title.empty() || unit.empty() ? "" : " ") + in_brackets(unit);
  return (head.empty() ? "" : head + "\n") + table.text() + "\n";
}

}  // namespace

std::string study_text(const Json& summary, const study::Study& study) {
  std::string text = study.title().empty() ? "" : study.title() + "\n\n";
  for (const auto& metric : study.metrics()) text += metric_text(summary.at("variants"), metric);
  return text + verdicts_text(summary.at("variants")) + tables_text(summary, study);
}

std::string study_end_text(const Json& timed, const study::Study& study) {
  const std::size_t runs = study.variants().size() * static_cast<std::size_t>(study.runs());
  return fmt::format("{}, seed {}, wall time {}\n", counted(runs, "run"), study.seed(),
                     duration(timed.at("wall_s").get<double>()));
}

std::string tables_text(const Json& summary, const study::Study& study) {
  std::string text;
  for (std::size_t t = 0; t < study.tables().size(); ++t)
    text += table_text(summary.contains("tables") ? summary.at("tables")[t] : summary.at("table"),
                       study.tables()[t].shows_errors);
  return text;
}

}  // namespace binnacle::command
