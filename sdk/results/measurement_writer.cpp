// SPDX-License-Identifier: Apache-2.0
#include "measurement_writer.hpp"

#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include "attributes.hpp"
#include "results/results.hpp"

namespace binnacle::results {

MeasurementWriter::MeasurementWriter(nc::Group group, const MeasurementInfo& info, int level, WriterThread& thread)
    : group_(group), info_(info), level_(level), thread_(thread) {
  group.put_text(NC_GLOBAL, "measurement", info.name);
  reasons_[""] = 0;
}

// ---- by the run's thread

void MeasurementWriter::Slot::pad(std::size_t samples) {
  for (auto* values : {&residual, &sigma, &noise}) values->resize(samples, not_a_number);
  key.resize(samples, NC_FILL_INT64);
}

std::size_t MeasurementWriter::Batch::bytes() const {
  std::size_t columns = 4;
  for (const auto& of_group : slots) columns += 4 * of_group.size();
  return columns * sizeof(double) * t.size();
}

void MeasurementWriter::add(const UpdateRecord& record) {
  batch_.t.push_back(nearest_seconds(record.t));
  batch_.outcome.push_back(static_cast<signed char>(record.outcome));
  batch_.reason.push_back(number_of(record.reason));
  const bool is_linearized = record.residual != nullptr;
  batch_.nis.push_back(is_linearized ? record.nis : not_a_number);
  batch_.rows.push_back(record.rows);
  if (is_linearized) add_rows(record);
  if (batch_.t.size() == chunk_size) flush();
}

void MeasurementWriter::add_rows(const UpdateRecord& record) {
  batch_.slots.resize(info_.groups.size());
  std::size_t in_group = 0;
  for (int i = 0; i < record.rows; ++i) {
    const int group = record.row_groups[i];
    in_group = i > 0 && record.row_groups[i - 1] == group ? in_group + 1 : 0;
    auto& slots = batch_.slots[as_size(group)];
    if (slots.size() <= in_group) slots.resize(in_group + 1);
    Slot& slot = slots[in_group];
    slot.pad(batch_.t.size() - 1);
    slot.residual.push_back(record.residual[i]);
    slot.sigma.push_back(std::sqrt(record.S(i, i)));
    slot.noise.push_back(std::sqrt(record.R(i, i)));
    slot.key.push_back(record.row_keys[i]);
  }
}

std::int32_t MeasurementWriter::number_of(const char* reason) {
  const auto found = reasons_.find(std::string_view(reason));
  if (found != reasons_.end()) return found->second;
  return reasons_.emplace(reason, static_cast<std::int32_t>(reasons_.size())).first->second;
}

void MeasurementWriter::flush() {
  if (batch_.t.empty()) return;
  const std::size_t bytes = batch_.bytes();
  const auto batch = std::make_shared<Batch>(std::exchange(batch_, {}));
  thread_.post(bytes, [this, batch] {
    try {
      write(*batch);
    } catch (const nc::Failure& failure) {
      throw WriteError(failure.what());
    }
  });
}

// ---- by the writer's thread

void MeasurementWriter::write(Batch& batch) {
  const std::size_t samples = batch.t.size();
  if (!is_defined_) define(samples);
  batch.slots.resize(row_groups_.size());
  for (std::size_t g = 0; g < row_groups_.size(); ++g) {
    Rows& rows = row_groups_[g];
    auto& slots = batch.slots[g];
    rows.are_there = rows.are_there || !slots.empty();
    if (rows.are_there && slots.empty()) slots.resize(1);  // the first is as long as the time
    for (std::size_t s = 0; s < slots.size(); ++s) {
      slots[s].pad(samples);
      const auto write_column = [&]<class T>(int variable, const std::vector<T>& values) {
        write_rows<T>(group_, {variable, static_cast<int>(s)}, first_, values);
      };
      write_column(rows.residual, slots[s].residual);
      write_column(rows.sigma, slots[s].sigma);
      write_column(rows.noise, slots[s].noise);
      write_column(rows.key, slots[s].key);
    }
  }
  write_rows<double>(group_, {time_}, first_, batch.t);
  write_rows<signed char>(group_, {outcome_}, first_, batch.outcome);
  write_rows<std::int32_t>(group_, {reason_}, first_, batch.reason);
  write_rows<double>(group_, {nis_}, first_, batch.nis);
  write_rows<std::int32_t>(group_, {rows_}, first_, batch.rows);
  first_ += samples;
}

void MeasurementWriter::close() {
  if (!is_defined_) define(1);
  std::vector<std::string> texts(reasons_.size());
  for (const auto& [text, number] : reasons_) texts[as_size(number)] = text;
  const int dimension = group_.add_dimension("reason_text", texts.size());
  const int id = group_.add_texts("reason_text", {dimension}, texts);
  group_.put_text(id, "long_name", "texts for the index `reason`; empty: the sample was used");
}

/// As soon as it is known how long a chunk may be: that of a few samples would be mostly empty.
void MeasurementWriter::define(std::size_t samples) {
  is_defined_ = true;
  samples_of_chunk_ = samples;
  time_dimension_ = group_.add_growing_dimension("time");
  time_ = add_time(group_, "time", time_dimension_, growing(1, samples, level_), "time of the sample");
  add_outcome();
  reason_ = add_variable("reason", NC_INT);
  nis_ = add_variable("nis", NC_DOUBLE);
  rows_ = add_variable("rows", NC_INT);
  describe(reason_, "why the sample was not used: index in reason_text", "");
  describe(nis_, "normalized innovation squared, r' (H P H' + R)^-1 r; chi-squared of `rows` degrees of freedom", "1");
  group_.fill_with_nan(nis_);
  describe(rows_, "rows of the sample that nis is of", "");
  for (const auto& row_group : info_.groups) add_row_group(row_group, info_.groups.size() > 1);
}

int MeasurementWriter::add_variable(const std::string& name, nc_type type) {
  return group_.add_variable(name, type, {time_dimension_}, growing(1, samples_of_chunk_, level_));
}

void MeasurementWriter::describe(int variable, const std::string& long_name, const std::string& unit) {
  group_.put_text(variable, "long_name", long_name);
  put_if_any(group_, variable, "units", unit);
}

void MeasurementWriter::add_outcome() {
  outcome_ = add_variable("outcome", NC_BYTE);
  group_.put_text(outcome_, "long_name", "outcome of the sample");
  std::vector<signed char> values(outcome_count);
  std::string meanings;
  for (int o = 0; o < outcome_count; ++o) {
    values[as_size(o)] = static_cast<signed char>(o);
    meanings += (o ? " " : "") + std::string(outcome_names[as_size(o)]);
  }
  group_.put_bytes(outcome_, "flag_values", values);
  group_.put_text(outcome_, "flag_meanings", meanings);
}

void MeasurementWriter::add_row_group(const RowGroupInfo& info, bool is_one_of_several) {
  Rows rows;
  const std::string suffix = is_one_of_several ? names_.take("_" + identifier(info.name)) : "";
  const int row_dimension = group_.add_growing_dimension("row" + suffix);
  const auto add = [&](const char* name, nc_type type, const std::string& long_name, const std::string& unit) {
    const int id = group_.add_variable(name + suffix, type, {time_dimension_, row_dimension},
                                       growing(2, samples_of_chunk_, level_));
    describe(id, long_name, unit);
    put_if_any(group_, id, "row_group", info.name);
    if (type == NC_DOUBLE) group_.fill_with_nan(id);
    return id;
  };
  const std::string of = " of the rows '" + info.name + "'";
  rows.residual = add("residual", NC_DOUBLE, "measured - predicted" + of, info.unit);
  rows.sigma =
      add("residual_sigma", NC_DOUBLE,
          "the filter's uncertainty of the residual" + of + ", 1-sigma: root of the diagonal of H P H' + R", info.unit);
  rows.noise =
      add("noise", NC_DOUBLE,
          "measurement noise" + of + ", 1-sigma: root of the diagonal of R, adapted where a noise estimator does so",
          info.unit);
  rows.key = add("key", NC_INT64, "identity of the row, for example a satellite; otherwise its number", "");
  group_.put_text(rows.residual, "ancillary_variables",
                  "residual_sigma" + suffix + " noise" + suffix + " key" + suffix);
  row_groups_.push_back(rows);
}

}  // namespace binnacle::results
