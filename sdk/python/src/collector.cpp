// SPDX-License-Identifier: Apache-2.0
#include "collector.hpp"
#include "wording/wording.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <pybind11/stl.h>

namespace binnacle::python {

using wording::as_size;

Collector::Filter::Filter(const FilterInfo& info_of) : info(info_of), records(Records::of(info_of)) {
  for (const auto& measurement : info.measurements) {
    updates.emplace_back().measurement = measurement.name;
    for (const auto& group : measurement.groups) updates.back().groups.push_back({group.name, group.unit});
  }
}

Collector::Collector(const Composition& composition, const Kept& kept, Check check, command::RunRecorder* recorder)
    : kept_(kept), check_(std::move(check)), recorder_(recorder) {
  for (const auto& filter : score::filters_of(composition)) {
    Filter& own = filters_.emplace_back(filter);
    if (const auto wants = kept_.logs.find(filter.name); wants != kept_.logs.end())
      own.log = std::make_unique<StepLog>(filter, wants->second);
  }
}

void Collector::observe(std::size_t filter, const py::object& observer) {
  Filter& own = filters_[filter];
  own.observer =
      std::make_unique<PythonObserver>(own.info.name, observer, Sizes{own.info.dof, own.info.stored_size}, failure_);
}

void Collector::begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) {
  if (recorder_) recorder_->begin(filter, name, columns);
  Records& records = filters_[as_size(filter)].records;
  for (std::size_t i = records.columns(); i < columns.size(); ++i) records.others.push_back(columns[i]);
}

void Collector::record(int filter, Time t, std::span<const double> values) {
  if (recorder_) recorder_->record(filter, t, values);
  if (!kept_.records) return;
  Records& records = filters_[as_size(filter)].records;
  records.t.push_back(t);
  records.values.insert(records.values.end(), values.begin(), values.end());
}

StepObserver* Collector::step_observer(int filter) {
  Filter& own = filters_[as_size(filter)];
  if (recorder_) own.all.add(recorder_->step_observer(filter));
  if (kept_.updates) own.all.add(&own.update_log);
  own.all.add(own.log.get());
  own.all.add(own.observer.get());
  return own.all.joined();
}

void Collector::scored(int filter, const score::ErrorSeries& errors) {
  if (recorder_) recorder_->scored(filter, errors);
  if (!kept_.records) return;
  Filter& own = filters_[as_size(filter)];
  auto& error = own.errors.emplace_back();
  error.name = errors.name;
  error.unit = errors.unit;
  error.display_unit = errors.display_unit.empty() ? errors.unit : errors.display_unit;
  error.is_component = results::component_of(own.info, errors).first != nullptr;
  error.t.reserve(errors.t.size());
  for (const Time t : errors.t) error.t.push_back(results::nearest_seconds(t));
  error.values.assign(errors.values.begin(), errors.values.end());
  error.sigma.assign(errors.sigma.begin(), errors.sigma.end());
}

bool Collector::progress(Time) {
  failure_.raise();
  check_();
  return true;
}

py::list Collector::taken() {
  py::list filters;
  for (Filter& own : filters_) {
    py::dict filter = python::taken(std::move(own.records));
    py::list errors, updates;
    for (auto& error : own.errors) errors.append(python::taken(std::move(error)));
    for (auto& of_one : own.updates) updates.append(python::taken(std::move(of_one)));
    filter["errors"] = errors;
    filter["updates"] = updates;
    filter["log"] = own.log ? py::object(own.log->taken()) : py::none();
    filters.append(filter);
  }
  return filters;
}

void Collector::UpdateLog::offered(const UpdateRecord& record) {
  auto& updates = into_[as_size(record.measurement)];
  const bool is_linearized = record.residual != nullptr;
  updates.t.push_back(results::nearest_seconds(record.t));
  updates.outcome.push_back(record.outcome);
  updates.reason.emplace_back(record.reason);
  updates.nis.push_back(is_linearized ? record.nis : std::numeric_limits<double>::quiet_NaN());
  updates.rows.push_back(is_linearized ? record.rows : 0);
  if (!is_linearized) return;
  for (int i = 0; i < record.rows; ++i) {
    updates.group.push_back(record.row_groups[i]);
    updates.key.push_back(record.row_keys[i]);
    updates.residual.push_back(record.residual[i]);
    updates.sigma.push_back(std::sqrt(record.S(i, i)));
    updates.noise.push_back(std::sqrt(record.R(i, i)));
  }
}

}  // namespace binnacle::python
