// SPDX-License-Identifier: Apache-2.0
#include "collector.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace binnacle::python {

namespace {

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

}  // namespace

Collector::Collector(const Composition& composition, bool keeps_records, bool keeps_updates, GoesOn goes_on)
    : keeps_records_(keeps_records), keeps_updates_(keeps_updates), goes_on_(std::move(goes_on)) {
  for (const auto& filter : score::filters_of(composition)) {
    records_.push_back({filter.name, {}, {}, {}});
    errors_.emplace_back();
    auto& of_filter = updates_.emplace_back();
    for (const auto& measurement : filter.measurements) {
      of_filter.emplace_back().measurement = measurement.name;
      for (const auto& group : measurement.groups) of_filter.back().groups.push_back({group.name, group.unit});
    }
  }
  for (auto& of_filter : updates_) observers_.emplace_back(of_filter);
}

void Collector::begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) {
  records_[as_size(filter)].name = name;
  records_[as_size(filter)].columns = columns;
}

void Collector::record(int filter, Time t, std::span<const double> values) {
  auto& records = records_[as_size(filter)];
  records.t.push_back(t);
  records.values.insert(records.values.end(), values.begin(), values.end());
}

StepObserver* Collector::step_observer(int filter) { return keeps_updates_ ? &observers_[as_size(filter)] : nullptr; }

void Collector::scored(int filter, const score::ErrorSeries& errors) {
  auto& error = errors_[as_size(filter)].emplace_back();
  error.name = errors.name;
  error.unit = errors.unit;
  error.display_unit = errors.display_unit;
  error.t.reserve(errors.t.size());
  for (const Time t : errors.t) error.t.push_back(seconds(t));
  error.values.assign(errors.values.begin(), errors.values.end());
  error.sigma.assign(errors.sigma.begin(), errors.sigma.end());
}

bool Collector::progress(Time) {
  goes_on_();
  return true;
}

void Collector::Updates::offered(const UpdateRecord& record) {
  auto& updates = (*into_)[as_size(record.measurement)];
  const bool is_linearized = record.residual != nullptr;
  updates.t.push_back(seconds(record.t));
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
