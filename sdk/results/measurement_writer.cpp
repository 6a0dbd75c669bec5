// SPDX-License-Identifier: Apache-2.0
#include "measurement_writer.hpp"

#include <cmath>
#include <string_view>

#include "attributes.hpp"
#include "results/results.hpp"

namespace binnacle::results {

MeasurementWriter::MeasurementWriter(nc::Group group, const MeasurementInfo& info) : group_(group) {
  group.put_text(NC_GLOBAL, "measurement", info.name);
  time_dimension_ = group.add_growing_dimension("time");
  time_.emplace(group, add_time(group, "time", time_dimension_, "time of the sample"));
  add_outcome();
  reason_.emplace(group, group.add_variable("reason", NC_INT, {time_dimension_}, growing_chunks(1)));
  nis_.emplace(group, group.add_variable("nis", NC_DOUBLE, {time_dimension_}, growing_chunks(1)));
  rows_.emplace(group, group.add_variable("rows", NC_INT, {time_dimension_}, growing_chunks(1)));
  describe(id_of("reason"), "why the sample was not used: index in reason_text", "");
  describe(id_of("nis"),
           "normalized innovation squared, r' (H P H' + R)^-1 r; chi-squared of `rows` degrees of freedom", "1");
  group.fill_with_nan(id_of("nis"));
  describe(id_of("rows"), "rows of the sample that nis is of", "");
  for (const auto& row_group : info.groups) add_row_group(row_group, info.groups.size() > 1);
  reasons_[""] = 0;
}

void MeasurementWriter::add(const UpdateRecord& record) {
  time_->add(nearest_seconds(record.t));
  outcome_->add(static_cast<signed char>(record.outcome));
  reason_->add(number_of(record.reason));
  const bool is_linearized = record.residual != nullptr;
  nis_->add(is_linearized ? record.nis : not_a_number);
  rows_->add(record.rows);
  if (is_linearized) add_rows(record);
  if (time_->size() == chunk_size) write();
}

void MeasurementWriter::close() {
  write();
  std::vector<std::string> texts(reasons_.size());
  for (const auto& [text, number] : reasons_) texts[as_size(number)] = text;
  const int dimension = group_.add_dimension("reason_text", texts.size());
  const int id = group_.add_texts("reason_text", {dimension}, texts);
  group_.put_text(id, "long_name", "what `reason` is an index of; empty: it was used");
}

void MeasurementWriter::describe(int variable, const std::string& long_name, const std::string& unit) {
  group_.put_text(variable, "long_name", long_name);
  put_if_any(group_, variable, "units", unit);
}

void MeasurementWriter::add_outcome() {
  const int id = group_.add_variable("outcome", NC_BYTE, {time_dimension_}, growing_chunks(1));
  group_.put_text(id, "long_name", "what became of the sample");
  std::vector<signed char> values(outcome_count);
  std::string meanings;
  for (int o = 0; o < outcome_count; ++o) {
    values[as_size(o)] = static_cast<signed char>(o);
    meanings += (o ? " " : "") + std::string(outcome_names[as_size(o)]);
  }
  group_.put_bytes(id, "flag_values", values);
  group_.put_text(id, "flag_meanings", meanings);
  outcome_.emplace(group_, id);
}

void MeasurementWriter::add_row_group(const RowGroupInfo& info, bool is_one_of_several) {
  Rows rows;
  const std::string suffix = is_one_of_several ? names_.take("_" + identifier(info.name)) : "";
  rows.row_dimension = group_.add_growing_dimension("row" + suffix);
  const auto add = [&](const char* name, nc_type type, const std::string& long_name, const std::string& unit) {
    const int id = group_.add_variable(name + suffix, type, {time_dimension_, rows.row_dimension}, growing_chunks(2));
    describe(id, long_name, unit);
    put_if_any(group_, id, "row_group", info.name);
    if (type == NC_DOUBLE) group_.fill_with_nan(id);
    return id;
  };
  const std::string of = " of the rows '" + info.name + "'";
  rows.residual = add("residual", NC_DOUBLE, "measured - predicted" + of, info.unit);
  rows.sigma =
      add("residual_sigma", NC_DOUBLE,
          "what the filter expected of the residual" + of + ", 1-sigma: root of the diagonal of H P H' + R", info.unit);
  rows.noise =
      add("noise", NC_DOUBLE,
          "measurement noise" + of + ", 1-sigma: root of the diagonal of R, adapted where a noise estimator does so",
          info.unit);
  rows.key = add("key", NC_INT64, "who the row is: a satellite, say; else its number", "");
  group_.put_text(rows.residual, "ancillary_variables",
                  "residual_sigma" + suffix + " noise" + suffix + " key" + suffix);
  row_groups_.push_back(std::move(rows));
}

void MeasurementWriter::add_rows(const UpdateRecord& record) {
  int in_group = 0;
  for (int i = 0; i < record.rows; ++i) {
    const int group = record.row_groups[i];
    in_group = i > 0 && record.row_groups[i - 1] == group ? in_group + 1 : 0;
    auto& rows = row_groups_[as_size(group)];
    auto& slot = slot_of(rows, as_size(in_group));
    const std::size_t before = time_->size() - 1;
    slot.residual.pad(before, not_a_number);
    slot.sigma.pad(before, not_a_number);
    slot.noise.pad(before, not_a_number);
    slot.key.pad(before, NC_FILL_INT64);
    slot.residual.add(record.residual[i]);
    slot.sigma.add(std::sqrt(record.S(i, i)));
    slot.noise.add(std::sqrt(record.R(i, i)));
    slot.key.add(record.row_keys[i]);
  }
}

MeasurementWriter::Rows::Slot& MeasurementWriter::slot_of(Rows& rows, std::size_t index) {
  while (rows.slots.size() <= index) {
    const int column = static_cast<int>(rows.slots.size());
    rows.slots.push_back({{group_, rows.residual, column},
                          {group_, rows.sigma, column},
                          {group_, rows.noise, column},
                          {group_, rows.key, column}});
  }
  return rows.slots[index];
}

std::int32_t MeasurementWriter::number_of(const char* reason) {
  const auto found = reasons_.find(std::string_view(reason));
  if (found != reasons_.end()) return found->second;
  return reasons_.emplace(reason, static_cast<std::int32_t>(reasons_.size())).first->second;
}

void MeasurementWriter::write() {
  const std::size_t samples = time_->size();
  for (auto& rows : row_groups_)
    for (auto& slot : rows.slots) {
      const bool is_first = &slot == &rows.slots.front();
      if (slot.residual.size() == 0 && !is_first) continue;
      slot.residual.pad(samples, not_a_number);
      slot.sigma.pad(samples, not_a_number);
      slot.noise.pad(samples, not_a_number);
      slot.key.pad(samples, NC_FILL_INT64);
      slot.residual.write(first_);
      slot.sigma.write(first_);
      slot.noise.write(first_);
      slot.key.write(first_);
    }
  time_->write(first_);
  outcome_->write(first_);
  reason_->write(first_);
  nis_->write(first_);
  rows_->write(first_);
  first_ += samples;
}

}  // namespace binnacle::results
