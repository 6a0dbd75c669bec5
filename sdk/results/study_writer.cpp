// SPDX-License-Identifier: Apache-2.0
#include "results/study_writer.hpp"

#include <limits>

#include "names.hpp"
#include "netcdf.hpp"
#include "provenance.hpp"

namespace binnacle::results {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

void put_units(nc::Group group, int variable, const StudyResults::Metric& metric) {
  group.put_text(variable, "units", metric.si_unit);
  if (metric.unit != metric.si_unit) group.put_text(variable, "display_units", metric.unit);
}

int add_texts(nc::Group group, const std::string& name, const std::vector<int>& dimensions,
              const std::string& long_name, const std::vector<std::string>& texts) {
  const int id = group.add_texts(name, dimensions, texts);
  group.put_text(id, "long_name", long_name);
  return id;
}

void write_metrics(nc::Group root, const StudyResults& study, int variant_dimension, int run_dimension) {
  Names names;
  for (const char* taken : {"config", "plugin", "plugin_version", "plugin_path", "variant", "run", "state", "tables"})
    names.take(taken);
  const std::size_t runs = study.runs, metrics = study.metrics.size();
  for (std::size_t m = 0; m < metrics; ++m) {
    const auto& metric = study.metrics[m];
    const int id = root.add_variable(names.take(metric.name), NC_DOUBLE, {variant_dimension, run_dimension},
                                     {{1, std::min<std::size_t>(runs, 65536)}});
    root.fill_with_nan(id);
    root.put_text(id, "long_name", metric.name);
    root.put_text(id, "metric", metric.name);
    put_units(root, id, metric);
    for (std::size_t v = 0; v < study.variants.size(); ++v) {
      const std::size_t start[] = {v, 0}, count[] = {1, runs};
      root.write(id, start, count, study.values.data() + (v * metrics + m) * runs);
    }
  }
}

/// Which runs broke; why is in study.json.
void write_state(nc::Group root, const StudyResults& study, int variant_dimension, int run_dimension) {
  const int id = root.add_variable("state", NC_BYTE, {variant_dimension, run_dimension}, {{1, study.runs}});
  root.put_text(id, "long_name", "outcome of the run");
  root.put_bytes(id, "flag_values", {0, 1});
  root.put_text(id, "flag_meanings", "finished failed");
  std::vector<signed char> states(study.variants.size() * study.runs, 0);
  for (std::size_t v = 0; v < study.variants.size(); ++v) {
    const Json& variant = study.figures.at("variants").at(study.variants[v]);
    if (!variant.contains("failures")) continue;
    for (const auto& failure : variant.at("failures"))
      states.at(v * study.runs + failure.at("run").get<std::size_t>()) = 1;
  }
  const std::size_t start[] = {0, 0}, count[] = {study.variants.size(), study.runs};
  root.write(id, start, count, states.data());
}

std::vector<std::string> texts_of(const Json& list) {
  std::vector<std::string> texts;
  for (const auto& entry : list) texts.push_back(entry.is_string() ? entry.get<std::string>() : "");
  return texts;
}

/// Row by row; what is no number is NaN.
std::vector<double> numbers_of(const Json& rows) {
  std::vector<double> numbers;
  for (const auto& row : rows)
    for (const auto& cell : row) numbers.push_back(cell.is_number() ? cell.get<double>() : not_a_number);
  return numbers;
}

void write_table(nc::Group group, const Json& table) {
  const auto rows = texts_of(table.at("rows")), columns = texts_of(table.at("columns"));
  group.put_text(NC_GLOBAL, "title", table.at("title").get<std::string>());
  if (rows.empty() || columns.empty()) return;
  const int row = group.add_dimension("row", rows.size()), column = group.add_dimension("column", columns.size());
  add_texts(group, "row", {row}, "rows of the table", rows);
  add_texts(group, "column", {column}, "columns of the table", columns);
  std::vector<std::string> units, cells;
  for (const auto& line : table.at("units"))
    for (const auto& unit : line) units.push_back(unit.get<std::string>());
  for (const auto& line : table.at("cells"))
    for (const auto& cell : line) cells.push_back(cell.is_string() ? cell.get<std::string>() : "");
  add_texts(group, "unit", {row, column}, "units of the values", units);
  add_texts(group, "text", {row, column}, "text of a cell without a value", cells);
  const auto add = [&](const char* name, const char* long_name, const Json& values) {
    const int id = group.add_variable(name, NC_DOUBLE, {row, column}, {{rows.size(), columns.size()}});
    group.fill_with_nan(id);
    group.put_text(id, "long_name", long_name);
    const std::size_t start[] = {0, 0}, count[] = {rows.size(), columns.size()};
    group.write(id, start, count, numbers_of(values).data());
  };
  add("value", "value of the cell, in its unit", table.at("cells"));
  add("se", "standard error of the value", table.at("se"));
  if (table.contains("paper")) add("paper", "what the paper has", table.at("paper"));
}

void write_tables(nc::Group root, const Json& figures) {
  const Json tables = figures.contains("tables")  ? figures.at("tables")
                      : figures.contains("table") ? Json::array({figures.at("table")})
                                                  : Json::array();
  if (tables.empty()) return;
  const nc::Group all = root.add_group("tables");
  for (std::size_t i = 0; i < tables.size(); ++i)
    write_table(all.add_group("table_" + std::to_string(i + 1)), tables[i]);
}

}  // namespace

void write_study(const std::filesystem::path& path, const StudyResults& study) {
  try {
    nc::File file = nc::File::create(path);
    const nc::Group root = file.root();
    write_provenance(root, "study", study.config, study.provenance);
    const int variant = root.add_dimension("variant", study.variants.size());
    const int run = root.add_dimension("run", study.runs);
    add_texts(root, "variant", {variant}, "variants of the config", study.variants);
    const int id = root.add_variable("run", NC_INT, {run}, {{study.runs}});
    root.put_text(id, "long_name", "which run of the seed");
    std::vector<std::int32_t> numbers(study.runs);
    for (std::size_t k = 0; k < study.runs; ++k) numbers[k] = static_cast<std::int32_t>(k);
    const std::size_t start = 0;
    root.write(id, &start, &study.runs, numbers.data());
    write_state(root, study, variant, run);
    write_metrics(root, study, variant, run);
    write_tables(root, study.figures);
    file.close();
  } catch (const nc::Failure& failure) {
    throw WriteError(failure.what());
  }
}

}  // namespace binnacle::results
