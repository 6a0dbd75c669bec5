// SPDX-License-Identifier: Apache-2.0
#include "results.hpp"
#include "binnacle/state_block.hpp"

#include <cstdint>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include <pybind11/stl.h>

namespace binnacle::python {

Records Records::of(const FilterInfo& filter) {
  Records records;
  records.name = filter.name;
  for (const auto& block : filter.blocks)
    for (const auto& output : block.declaration->outputs)
      records.outputs.push_back(
          {block.name, output.name, output.unit, output.display_unit.empty() ? output.unit : output.display_unit});
  return records;
}

py::dict taken(Records&& records) {
  py::list outputs, others;
  for (const auto& output : records.outputs)
    outputs.append(py::make_tuple(output.block, output.output, output.unit, output.display_unit));
  for (const auto& column : records.others) others.append(py::make_tuple(column.name, column.unit));
  std::vector<double> t;
  t.reserve(records.t.size());
  for (const Time time : records.t) t.push_back(results::nearest_seconds(time));
  const auto rows = static_cast<py::ssize_t>(records.t.size()), columns = static_cast<py::ssize_t>(records.columns());
  py::dict dict;
  dict["name"] = records.name;
  dict["outputs"] = outputs;
  dict["others"] = others;
  dict["t"] = to_array(std::move(t));
  dict["t_ns"] = to_array(std::move(records.t));
  dict["values"] = to_array(std::move(records.values), {rows, columns});
  return dict;
}

py::dict taken(results::Error&& error) {
  py::dict dict;
  dict["name"] = error.name;
  dict["unit"] = error.unit;
  dict["display_unit"] = error.display_unit;
  dict["is_component"] = error.is_component;
  dict["t"] = to_array(std::move(error.t));
  dict["values"] = to_array(std::move(error.values));
  dict["sigma"] = error.sigma.empty() ? py::object(py::none()) : to_array(std::move(error.sigma));
  return dict;
}

py::dict taken(results::Updates&& updates) {
  std::vector<std::int8_t> outcomes;
  outcomes.reserve(updates.outcome.size());
  for (const Outcome outcome : updates.outcome) outcomes.push_back(static_cast<std::int8_t>(outcome));
  std::vector<std::int32_t> reasons;
  reasons.reserve(updates.reason.size());
  std::unordered_map<std::string, std::int32_t> numbers;
  py::list groups, texts;
  for (const auto& reason : updates.reason) {
    const auto [found, is_new] = numbers.try_emplace(reason, static_cast<std::int32_t>(numbers.size()));
    if (is_new) texts.append(reason);
    reasons.push_back(found->second);
  }
  for (const auto& group : updates.groups) groups.append(py::make_tuple(group.name, group.unit));
  py::dict dict;
  dict["measurement"] = updates.measurement;
  dict["groups"] = groups;
  dict["t"] = to_array(std::move(updates.t));
  dict["outcome"] = to_array(std::move(outcomes));
  dict["reason"] = to_array(std::move(reasons));
  dict["reasons"] = texts;
  dict["nis"] = to_array(std::move(updates.nis));
  dict["rows"] = to_array(std::move(updates.rows));
  dict["group"] = to_array(std::move(updates.group));
  dict["key"] = to_array(std::move(updates.key));
  dict["residual"] = to_array(std::move(updates.residual));
  dict["sigma"] = to_array(std::move(updates.sigma));
  dict["noise"] = to_array(std::move(updates.noise));
  return dict;
}

py::dict taken(results::StudyResults&& study) {
  py::list metrics;
  for (const auto& metric : study.metrics) metrics.append(py::make_tuple(metric.name, metric.si_unit, metric.unit));
  const auto size = [](std::size_t count) { return static_cast<py::ssize_t>(count); };
  py::dict dict;
  dict["figures"] = to_python(study.figures);
  dict["config"] = to_python(study.config);
  dict["provenance"] = to_python(study.provenance);
  dict["variants"] = study.variants;
  dict["metrics"] = metrics;
  dict["values"] =
      to_array(std::move(study.values), {size(study.variants.size()), size(study.metrics.size()), size(study.runs)});
  return dict;
}

namespace {

/// A double holds nanoseconds for 104 days; of clocks that count longer it is the nearest to what was written.
Time nearest_nanoseconds(double s) { return static_cast<Time>(std::llroundl(static_cast<long double>(s) * 1e9L)); }

Records records_of(results::FilterResults& filter) {
  Records records;
  records.name = filter.name;
  for (const auto& estimate : filter.estimates)
    records.outputs.push_back({estimate.block, estimate.output, estimate.unit, estimate.display_unit});
  for (const auto& other : filter.others) records.others.push_back({other.name, other.unit});
  records.values.reserve(filter.t.size() * records.columns());
  for (std::size_t i = 0; i < filter.t.size(); ++i) {
    records.t.push_back(nearest_nanoseconds(filter.t[i]));
    for (const auto& estimate : filter.estimates) records.values.push_back(estimate.values[i]);
    for (const auto& estimate : filter.estimates) records.values.push_back(estimate.sigma[i]);
    for (const auto& other : filter.others) records.values.push_back(other.values[i]);
  }
  return records;
}

py::dict run_of(results::RunResults&& run) {
  py::list filters;
  for (auto& of_file : run.filters) {
    py::dict filter = taken(records_of(of_file));
    py::list errors, updates;
    for (auto& error : of_file.errors) errors.append(taken(std::move(error)));
    for (auto& of_one : of_file.updates) updates.append(taken(std::move(of_one)));
    filter["t"] = to_array(std::move(of_file.t));
    filter["errors"] = errors;
    filter["updates"] = updates;
    filters.append(filter);
  }
  py::dict dict;
  dict["filters"] = filters;
  dict["summary"] = to_python(run.summary);
  dict["config"] = to_python(run.config);
  dict["provenance"] = to_python(run.provenance);
  return dict;
}

/// (run, study): each None where the folder has none.
py::tuple open_results(const std::string& folder) {
  results::Results all;
  {
    const py::gil_scoped_release unlocked;
    try {
      all = results::read(folder);
    } catch (const std::runtime_error& error) {
      const py::gil_scoped_acquire locked;
      const py::object type = py::module_::import("binnacle._errors").attr("DataError");
      PyErr_SetObject(type.ptr(), type(std::string(error.what())).ptr());
      throw py::error_already_set();
    }
  }
  return py::make_tuple(all.run ? py::object(run_of(std::move(*all.run))) : py::none(),
                        all.study ? py::object(taken(std::move(*all.study))) : py::none());
}

}  // namespace

void bind_results(py::module_& module) {
  module.def("open", &open_results, py::arg("folder"));
  module.attr("outcomes") = py::tuple(py::cast(results::outcome_names));
}

}  // namespace binnacle::python
