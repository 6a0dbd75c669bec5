// SPDX-License-Identifier: Apache-2.0
#include "study/summary.hpp"

#include <cmath>

#include "binnacle/unit.hpp"
#include "chi_squared/chi_squared.hpp"

namespace binnacle::study {

namespace {

using Json = nlohmann::ordered_json;
using State = Figures::State;

constexpr double consistent = 0.99;

double scale_of(const std::string& unit) {
  const auto parsed = parse_unit(unit);
  return parsed ? 1 / parsed->scale : 1.0;
}

std::vector<double> scaled(std::vector<double> values, double scale) {
  for (double& value : values) value *= scale;
  return values;
}

/// dump() writes NaN as null; so does what is compared and printed.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// Degrees of freedom of one sample, and how many samples all runs have together; their mean over the runs is judged.
void add_band(const Results& results, std::size_t variant, std::size_t metric, Json& entry) {
  double samples = 0, dof = 0;
  for (std::size_t run = 0; run < results.runs(); ++run) {
    const auto& figures = results.at(variant, run);
    if (figures.state != State::finished || std::isnan(figures.values[metric].value)) continue;
    samples += figures.values[metric].n;
    dof += figures.values[metric].n * figures.values[metric].dof;
  }
  if (!(dof > 0)) return;
  const auto [low, high] = chi_squared_band(dof / samples, samples, consistent);
  entry["dof"] = dof / samples;
  entry["band"] = {low, high};
}

Json metric_entry(const Study& study, const Results& results, std::size_t variant, std::size_t metric) {
  const auto& plan = study.metrics()[metric];
  const auto x = scaled(results.values(variant, metric), scale_of(plan.unit));
  Json entry;
  const auto add = [&](const char* name, OverRuns statistic) { entry[name] = number(over_runs(x, statistic)); };
  add("rms", OverRuns::rms);
  add("mean", OverRuns::mean);
  add("std", OverRuns::std);
  entry["se"] = number(standard_error(x, OverRuns::mean));
  entry["se_rms"] = number(standard_error(x, OverRuns::rms));
  add("p50", OverRuns::p50);
  add("p95", OverRuns::p95);
  add("max", OverRuns::max);
  entry["n"] = x.size();
  if (plan.is_chi_squared) add_band(results, variant, metric, entry);
  entry["unit"] = plan.unit;
  return entry;
}

/// How many of the finished runs ended with each verdict.
Json verdicts_of(const Results& results, std::size_t variant) {
  Json counts{{"ok", 0}, {"doubtful", 0}, {"lost", 0}};
  for (std::size_t run = 0; run < results.runs(); ++run)
    if (const auto& figures = results.at(variant, run); figures.state == State::finished) {
      Json& count = counts[verdict_name(figures.verdict)];
      count = count.get<int>() + 1;
    }
  return counts;
}

Json variant_entry(const Study& study, const Results& results, std::size_t variant) {
  Json failures = Json::array();
  for (std::size_t run = 0; run < results.runs(); ++run)
    if (results.at(variant, run).state == State::failed)
      failures.push_back({{"run", run}, {"reason", results.at(variant, run).failure}});
  Json entry{{"runs", results.runs()}, {"failed", failures.size()}, {"verdicts", verdicts_of(results, variant)}};
  Json metrics = Json::object();
  for (std::size_t m = 0; m < study.metrics().size(); ++m)
    if (study.variants()[variant].position[m] >= 0)
      metrics[study.metrics()[m].name] = metric_entry(study, results, variant, m);
  entry["metrics"] = std::move(metrics);
  if (!failures.empty()) entry["failures"] = std::move(failures);
  return entry;
}

/// Values of the runs that both variants finished, for paired comparison.
std::pair<std::vector<double>, std::vector<double>> paired(const Results& results, const Cell& cell) {
  const auto variant = static_cast<std::size_t>(cell.variant), baseline = static_cast<std::size_t>(cell.baseline);
  const auto metric = static_cast<std::size_t>(cell.metric);
  std::pair<std::vector<double>, std::vector<double>> values;
  for (std::size_t run = 0; run < results.runs(); ++run) {
    const auto &a = results.at(variant, run), &b = results.at(baseline, run);
    if (a.state != State::finished || b.state != State::finished) continue;
    if (std::isnan(a.values[metric].value) || std::isnan(b.values[metric].value)) continue;
    values.first.push_back(a.values[metric].value);
    values.second.push_back(b.values[metric].value);
  }
  return values;
}

struct CellFigures {
  double value = std::nan("");
  double se = std::nan("");
};

CellFigures figures_of(const Results& results, const Cell& cell) {
  if (cell.variant < 0 || (cell.show != Show::value && cell.baseline < 0)) return {};
  if (cell.show == Show::value) {
    const auto x = scaled(results.values(static_cast<std::size_t>(cell.variant), static_cast<std::size_t>(cell.metric)),
                          (cell.is_reversed ? -1 : 1) * scale_of(cell.unit));
    return {over_runs(x, cell.statistic), standard_error(x, cell.statistic)};
  }
  const auto [x, baseline] = paired(results, cell);
  const Ratio ratio = ratio_of(x, baseline, cell.statistic);
  if (cell.show == Show::ratio) return {ratio.value, ratio.se};
  return {100 * (1 - ratio.value), 100 * ratio.se};
}

Json table_entry(const Results& results, const TablePlan& table) {
  Json cells = Json::array(), errors = Json::array(), units = Json::array();
  for (const auto& row : table.cells) {
    Json values = Json::array(), ses = Json::array(), row_units = Json::array();
    for (const auto& cell : row) {
      const auto figures = figures_of(results, cell);
      values.push_back(cell.text.empty() ? number(figures.value) : Json(cell.text));
      ses.push_back(number(figures.se));
      row_units.push_back(cell.unit);
    }
    cells.push_back(std::move(values));
    errors.push_back(std::move(ses));
    units.push_back(std::move(row_units));
  }
  Json entry{{"title", table.title}, {"rows", table.rows}, {"columns", table.columns}};
  entry["cells"] = std::move(cells);
  entry["se"] = std::move(errors);
  entry["units"] = std::move(units);
  if (!table.paper.empty()) {
    Json paper = Json::array();
    for (const auto& row : table.paper) {
      Json figures = Json::array();
      for (const double figure : row) figures.push_back(number(figure));
      paper.push_back(std::move(figures));
    }
    entry["paper"] = std::move(paper);
  }
  return entry;
}

/// RFC 4180: quotes around what has a comma or quotes in it.
std::string csv(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

std::string csv(const Json& value) {
  if (value.is_string()) return csv(value.get<std::string>());
  return value.is_null() ? "" : value.dump();
}

}  // namespace

Json summarize(const Study& study, const Results& results) {
  Json summary{{"runs", results.runs()}, {"seed", study.seed()}};
  Json variants = Json::object();
  for (std::size_t v = 0; v < study.variants().size(); ++v)
    variants[study.variants()[v].name] = variant_entry(study, results, v);
  summary["variants"] = std::move(variants);
  Json tables = Json::array();
  for (const auto& table : study.tables()) tables.push_back(table_entry(results, table));
  if (!tables.empty()) summary["table"] = tables.front();
  if (tables.size() > 1) summary["tables"] = std::move(tables);
  return summary;
}

std::string runs_csv(const Study& study, const Results& results) {
  std::string text = "variant,run,seed,metric,value,unit\n";
  for (std::size_t v = 0; v < study.variants().size(); ++v)
    for (std::size_t run = 0; run < results.runs(); ++run)
      for (std::size_t m = 0; m < study.metrics().size(); ++m) {
        if (study.variants()[v].position[m] < 0) continue;
        const auto& figures = results.at(v, run);
        const auto& metric = study.metrics()[m];
        const bool is_there = figures.state == State::finished;
        const double value = is_there ? figures.values[m].value * scale_of(metric.unit) : std::nan("");
        text += csv(study.variants()[v].name) + "," + std::to_string(run) + "," + std::to_string(study.seed()) + "," +
                csv(metric.name) + "," + csv(number(value)) + "," + csv(metric.unit) + "\n";
      }
  return text;
}

std::string tables_csv(const Json& summary) {
  std::string text = "table,row,column,value,se,unit,paper\n";
  const auto add = [&text](const Json& table) {
    for (std::size_t r = 0; r < table.at("rows").size(); ++r)
      for (std::size_t c = 0; c < table.at("columns").size(); ++c) {
        text += csv(table.at("title").get<std::string>()) + "," + csv(table.at("rows")[r].get<std::string>()) + "," +
                csv(table.at("columns")[c].get<std::string>()) + "," + csv(table.at("cells")[r][c]) + "," +
                csv(table.at("se")[r][c]) + "," + csv(table.at("units")[r][c].get<std::string>()) + "," +
                (table.contains("paper") ? csv(table.at("paper")[r][c]) : "") + "\n";
      }
  };
  if (summary.contains("tables"))
    for (const auto& table : summary.at("tables")) add(table);
  else if (summary.contains("table"))
    add(summary.at("table"));
  return text;
}

}  // namespace binnacle::study
