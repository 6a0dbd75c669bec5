// SPDX-License-Identifier: Apache-2.0
#include "step_log.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <pybind11/stl.h>

namespace binnacle::python {

namespace {

py::dict lists_of(std::vector<Ragged>& all, const std::vector<const char*>& names) {
  py::dict dict;
  for (std::size_t i = 0; i < all.size(); ++i)
    dict[names[i]] = py::make_tuple(to_array(std::move(all[i].numbers)), to_array(std::move(all[i].ends)));
  return dict;
}

template <class Fields>
std::vector<const char*> names_of(const Fields& fields) {
  std::vector<const char*> names;
  for (const auto& field : fields) names.push_back(field.name);
  return names;
}

template <class Record>
void add(std::vector<Ragged>& all, std::span<const Field<Record>> fields, const Record& record, const Sizes& sizes,
         Wants wants) {
  for (std::size_t i = 0; i < fields.size(); ++i) all[i].add(fields[i].wanted(record, sizes, wants));
}

void pop(std::vector<Ragged>& all) {
  for (Ragged& each : all) each.pop();
}

}  // namespace

StepLog::StepLog(const FilterInfo& filter, Wants wants)
    : filter_(filter),
      sizes_{filter.dof, filter.stored_size},
      wants_(wants),
      starts_(2),
      steps_(step_fields().size()),
      updates_(update_fields().size()),
      inflations_(inflation_fields().size()) {}

void StepLog::started(Time t, const double* x, ConstMatrixView P) {
  kinds_.push_back(static_cast<std::int8_t>(Kind::start));
  times_.push_back(t);
  starts_[0].add({x, sizes_.stored, 1, sizes_.stored});
  starts_[1].add(P);
}

void StepLog::stepped(const StepRecord& record) {
  kinds_.push_back(static_cast<std::int8_t>(Kind::step));
  times_.push_back(record.t1);
  t0_.push_back(record.t0);
  add(steps_, step_fields(), record, sizes_, wants_);
}

void StepLog::offered(const UpdateRecord& record) {
  kinds_.push_back(static_cast<std::int8_t>(Kind::update));
  times_.push_back(record.t);
  measurement_.push_back(record.measurement);
  outcome_.push_back(static_cast<std::int8_t>(record.outcome));
  reason_.emplace_back(record.reason);
  rows_.push_back(record.residual ? record.rows : 0);
  nis_.push_back(record.residual ? record.nis : std::numeric_limits<double>::quiet_NaN());
  add(updates_, update_fields(), record, sizes_, wants_);
}

void StepLog::inflated(const InflationRecord& record) {
  kinds_.push_back(static_cast<std::int8_t>(Kind::inflation));
  times_.push_back(record.t);
  opened_by_.push_back(record.measurement);
  add(inflations_, inflation_fields(), record, sizes_, wants_);
}

void StepLog::pop() {
  switch (static_cast<Kind>(kinds_.back())) {
    case Kind::start: python::pop(starts_); break;
    case Kind::step:
      t0_.pop_back();
      python::pop(steps_);
      break;
    case Kind::update:
      measurement_.pop_back();
      outcome_.pop_back();
      reason_.pop_back();
      rows_.pop_back();
      nis_.pop_back();
      python::pop(updates_);
      break;
    case Kind::inflation:
      opened_by_.pop_back();
      python::pop(inflations_);
      break;
  }
  kinds_.pop_back();
  times_.pop_back();
}

void StepLog::rewound(Time t) {
  const auto is_void = [t](Time time) { return t == no_time || time > t; };
  const auto first = std::find_if(times_.begin(), times_.end(), is_void);
  const auto left = static_cast<std::size_t>(first - times_.begin());
  std::vector<Refusal> refusals;  // of older samples, which stay
  while (times_.size() > left) {
    if (!is_void(times_.back()) && kinds_.back() == static_cast<std::int8_t>(Kind::update))
      refusals.push_back({times_.back(), measurement_.back(), outcome_.back(), reason_.back()});
    pop();
  }
  for (auto refusal = refusals.rbegin(); refusal != refusals.rend(); ++refusal) {
    UpdateRecord record;
    record.t = refusal->t;
    record.measurement = refusal->measurement;
    record.outcome = static_cast<Outcome>(refusal->outcome);
    record.reason = refusal->reason.c_str();
    offered(record);
  }
}

py::dict StepLog::taken() {
  std::vector<std::string> measurements;
  for (const auto& measurement : filter_.measurements) measurements.push_back(measurement.name);
  py::dict dict;
  dict["rows_of_P"] = rows_of_P(filter_);
  dict["measurements"] = measurements;
  dict["stored"] = sizes_.stored;
  dict["kinds"] = to_array(std::move(kinds_));
  dict["times"] = to_array(std::move(times_));
  dict["t0"] = to_array(std::move(t0_));
  dict["measurement"] = to_array(std::move(measurement_));
  dict["outcome"] = to_array(std::move(outcome_));
  dict["reason"] = reason_;
  dict["rows"] = to_array(std::move(rows_));
  dict["nis"] = to_array(std::move(nis_));
  dict["opened_by"] = to_array(std::move(opened_by_));
  dict["starts"] = lists_of(starts_, {"x", "P"});
  dict["steps"] = lists_of(steps_, names_of(step_fields()));
  dict["updates"] = lists_of(updates_, names_of(update_fields()));
  dict["inflations"] = lists_of(inflations_, names_of(inflation_fields()));
  return dict;
}

}  // namespace binnacle::python
