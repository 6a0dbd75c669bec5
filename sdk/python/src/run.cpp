// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "collector.hpp"
#include "errors.hpp"
#include "interrupt.hpp"
#include "loaded.hpp"
#include "study/study.hpp"
#include "summary_text.hpp"

namespace binnacle::python {

namespace {

py::dict moved(Records&& records) {
  py::list columns;
  for (const auto& column : records.columns) columns.append(py::make_tuple(column.name, column.unit));
  py::dict dict;
  dict["name"] = records.name;
  dict["columns"] = columns;
  const auto rows = static_cast<py::ssize_t>(records.t.size());
  dict["t"] = to_array(std::move(records.t));
  dict["values"] = to_array(std::move(records.values), {rows, static_cast<py::ssize_t>(records.columns.size())});
  return dict;
}

py::dict moved(results::Error&& error) {
  py::dict dict;
  dict["name"] = error.name;
  dict["unit"] = error.unit;
  dict["display_unit"] = error.display_unit;
  dict["t"] = to_array(std::move(error.t));
  dict["values"] = to_array(std::move(error.values));
  dict["sigma"] = error.sigma.empty() ? py::object(py::none()) : to_array(std::move(error.sigma));
  return dict;
}

py::dict moved(results::Updates&& updates) {
  std::vector<std::int8_t> outcomes;
  for (const Outcome outcome : updates.outcome) outcomes.push_back(static_cast<std::int8_t>(outcome));
  py::list groups, reasons;
  for (const auto& group : updates.groups) groups.append(py::make_tuple(group.name, group.unit));
  for (const auto& reason : updates.reason) reasons.append(reason);
  py::dict dict;
  dict["measurement"] = updates.measurement;
  dict["groups"] = groups;
  dict["t"] = to_array(std::move(updates.t));
  dict["outcome"] = to_array(std::move(outcomes));
  dict["reason"] = reasons;
  dict["nis"] = to_array(std::move(updates.nis));
  dict["rows"] = to_array(std::move(updates.rows));
  dict["group"] = to_array(std::move(updates.group));
  dict["key"] = to_array(std::move(updates.key));
  dict["residual"] = to_array(std::move(updates.residual));
  dict["sigma"] = to_array(std::move(updates.sigma));
  dict["noise"] = to_array(std::move(updates.noise));
  return dict;
}

py::list filters_of(Collector& collector) {
  py::list filters;
  for (std::size_t f = 0; f < collector.records().size(); ++f) {
    py::dict filter = moved(std::move(collector.records()[f]));
    py::list errors, updates;
    for (auto& error : collector.errors()[f]) errors.append(moved(std::move(error)));
    for (auto& of_one : collector.updates()[f]) updates.append(moved(std::move(of_one)));
    filter["errors"] = errors;
    filter["updates"] = updates;
    filters.append(filter);
  }
  return filters;
}

py::dict run(const Loaded& loaded, std::uint64_t seed, int run_number, bool keeps_records, bool keeps_updates) {
  Collector collector(*loaded.composition, keeps_records, keeps_updates, SignalWatch());
  score::RunOptions options;
  options.seed = seed;
  options.run = run_number;
  options.observer = &collector;
  score::RunResult result;
  {
    const py::gil_scoped_release unlocked;
    study::refuse_misspelt_metrics(*loaded.composition, loaded.path, loaded.options);
    result = score::run(loaded.composition, options);
  }
  py::dict dict;
  dict["summary"] = to_python(result.summary);
  dict["text"] = command::summary_text(result.summary, *loaded.composition);
  dict["verdict"] = verdict_name(result.verdict);
  dict["warnings"] = to_python(result.warnings);
  dict["failures"] = to_python(result.failures);
  dict["doubts"] = to_python(result.doubts);
  dict["filters"] = filters_of(collector);
  return dict;
}

}  // namespace

void bind_run(py::module_& module) {
  module.def("run", &run, py::arg("loaded"), py::arg("seed"), py::arg("run"), py::arg("keeps_records"),
             py::arg("keeps_updates"));
}

}  // namespace binnacle::python
