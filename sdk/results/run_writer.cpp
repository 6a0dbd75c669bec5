// SPDX-License-Identifier: Apache-2.0
#include "results/run_writer.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <limits>
#include <map>
#include <optional>

#include "columns.hpp"
#include "frames.hpp"
#include "names.hpp"
#include "netcdf.hpp"
#include "provenance.hpp"

namespace binnacle::results {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

struct Units {
  std::string si, display;
};

void put_units(nc::Group group, int variable, const Units& units) {
  if (!units.si.empty()) group.put_text(variable, "units", units.si);
  if (!units.display.empty() && units.display != units.si) group.put_text(variable, "display_units", units.display);
}

void put_if_any(nc::Group group, int variable, const char* name, const std::string& text) {
  if (!text.empty()) group.put_text(variable, name, text);
}

/// CF wants "seconds since" an epoch of a time coordinate; which epoch a run's clock counts from nobody told us.
int add_time(nc::Group group, const std::string& name, int dimension, const std::string& long_name) {
  const int id = group.add_variable(name, NC_DOUBLE, {dimension}, growing_chunks(1));
  group.put_text(id, "units", "s");
  group.put_text(id, "long_name", long_name);
  group.put_text(id, "axis", "T");
  return id;
}

/// The names of a variable's columns, as a coordinate that has the dimension's own name.
int add_components(nc::Group group, const std::string& name, const std::vector<std::string>& components) {
  const int dimension = group.add_dimension(name, components.size());
  group.add_texts(name, {dimension}, components);
  return dimension;
}

/// Outputs that may be columns of one variable.
bool are_alike(const std::vector<Output>& outputs) {
  return outputs.size() > 1 && std::all_of(outputs.begin(), outputs.end(), [&](const Output& output) {
           return output.unit == outputs[0].unit && output.display_unit == outputs[0].display_unit;
         });
}

[[noreturn]] void rethrow_as_write_error(const nc::Failure& failure) { throw WriteError(failure.what()); }

template <class Action>
void guarded(Action&& action) {
  try {
    action();
  } catch (const nc::Failure& failure) {
    rethrow_as_write_error(failure);
  }
}

}  // namespace

/// What became of the samples of one measurement.
class RunWriter::Measurement {
 public:
  Measurement(nc::Group group, const MeasurementInfo& info) : group_(group) {
    group.put_text(NC_GLOBAL, "measurement", info.name);
    time_dimension_ = group.add_growing_dimension("time");
    time_.emplace(group, add_time(group, "time", time_dimension_, "time of the sample"));
    add_outcome();
    reason_.emplace(group, group.add_variable("reason", NC_INT, {time_dimension_}, growing_chunks(1)));
    nis_.emplace(group, group.add_variable("nis", NC_DOUBLE, {time_dimension_}, growing_chunks(1)));
    rows_.emplace(group, group.add_variable("rows", NC_INT, {time_dimension_}, growing_chunks(1)));
    describe(reason_id(), "why the sample was not used: index in reason_text", "");
    describe(id_of("nis"), "normalized innovation squared, r' (H P H' + R)^-1 r; chi-squared of `rows` degrees of freedom",
             "1");
    group.fill_with_nan(id_of("nis"));
    describe(id_of("rows"), "rows of the sample that nis is of", "");
    for (const auto& row_group : info.groups) add_row_group(row_group, info.groups.size() > 1);
    reasons_[""] = 0;
  }

  void add(const UpdateRecord& record) {
    time_->add(nearest_seconds(record.t));
    outcome_->add(static_cast<signed char>(record.outcome));
    reason_->add(number_of(record.reason));
    const bool is_linearized = record.residual != nullptr;
    nis_->add(is_linearized ? record.nis : not_a_number);
    rows_->add(record.rows);
    if (is_linearized) add_rows(record);
    if (time_->size() == chunk_size) write();
  }

  void close() {
    write();
    std::vector<std::string> texts(reasons_.size());
    for (const auto& [text, number] : reasons_) texts[as_size(number)] = text;
    const int dimension = group_.add_dimension("reason_text", texts.size());
    const int id = group_.add_texts("reason_text", {dimension}, texts);
    group_.put_text(id, "long_name", "what `reason` is an index of; empty: it was used");
  }

 private:
  /// Rows of one kind: variables (time, row), as wide as the widest sample.
  struct Rows {
    int row_dimension = 0;
    int residual = 0, sigma = 0, noise = 0, key = 0;
    struct Slot {
      Column<double> residual, sigma, noise;
      Column<std::int64_t> key;
    };
    std::deque<Slot> slots;
  };

  int id_of(const char* name) const { return *group_.variable(name); }
  int reason_id() const { return id_of("reason"); }

  void describe(int variable, const std::string& long_name, const std::string& unit) {
    group_.put_text(variable, "long_name", long_name);
    put_if_any(group_, variable, "units", unit);
  }

  void add_outcome() {
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

  void add_row_group(const RowGroupInfo& info, bool is_one_of_several) {
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
    rows.sigma = add("residual_sigma", NC_DOUBLE, "what the filter expected of the residual" + of +
                     ", 1-sigma: root of the diagonal of H P H' + R", info.unit);
    rows.noise = add("noise", NC_DOUBLE, "measurement noise" + of +
                     ", 1-sigma: root of the diagonal of R, adapted where a noise estimator does so", info.unit);
    rows.key = add("key", NC_INT64, "who the row is: a satellite, say; else its number", "");
    group_.put_text(rows.residual, "ancillary_variables", "residual_sigma" + suffix + " noise" + suffix + " key" + suffix);
    row_groups_.push_back(std::move(rows));
  }

  void add_rows(const UpdateRecord& record) {
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

  Rows::Slot& slot_of(Rows& rows, std::size_t index) {
    while (rows.slots.size() <= index) {
      const int column = static_cast<int>(rows.slots.size());
      rows.slots.push_back({{group_, rows.residual, column},
                            {group_, rows.sigma, column},
                            {group_, rows.noise, column},
                            {group_, rows.key, column}});
    }
    return rows.slots[index];
  }

  std::int32_t number_of(const char* reason) {
    const auto found = reasons_.find(std::string_view(reason));
    if (found != reasons_.end()) return found->second;
    return reasons_.emplace(reason, static_cast<std::int32_t>(reasons_.size())).first->second;
  }

  void write() {
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

  nc::Group group_;
  Names names_;
  int time_dimension_ = 0;
  std::optional<Column<double>> time_, nis_;
  std::optional<Column<signed char>> outcome_;
  std::optional<Column<std::int32_t>> reason_, rows_;
  std::vector<Rows> row_groups_;
  std::map<std::string, std::int32_t, std::less<>> reasons_;
  std::size_t first_ = 0;  // sample of the open chunk
};

class RunWriter::Filter : public StepTape {
 public:
  Filter(nc::Group group, const FilterInfo& info) : group_(group), info_(info) {
    group.put_text(NC_GLOBAL, "filter", info.name);
    names_.take("errors");
    names_.take("measurements");
    if (info.measurements.empty()) return;
    const nc::Group all = group.add_group("measurements");
    Names names;
    for (const auto& measurement : info.measurements)
      measurements_.push_back(std::make_unique<Measurement>(all.add_group(names.take(measurement.name)), measurement));
  }

  /// Columns come as the kernel records them: outputs block by block, their 1-σ in the same order, adapted noise.
  void begin(const std::vector<RecordColumn>& columns) {
    time_dimension_ = group_.add_growing_dimension(names_.take("time"));
    time_.emplace(group_, add_time(group_, "time", time_dimension_, "time of the estimates"));
    std::vector<Column<double>> sigmas;
    for (const auto& block : info_.blocks) add_block(block, sigmas);
    columns_.insert(columns_.end(), sigmas.begin(), sigmas.end());
    for (std::size_t i = columns_.size(); i < columns.size(); ++i) {
      const int id = group_.add_variable(names_.take(columns[i].name), NC_DOUBLE, {time_dimension_}, growing_chunks(1));
      group_.put_text(id, "long_name", columns[i].name + ": measurement noise as the noise estimator has it, 1-sigma");
      put_units(group_, id, {columns[i].unit, ""});
      columns_.emplace_back(group_, id);
    }
  }

  void record(Time t, std::span<const double> values) {
    tell_failure();
    time_->add(nearest_seconds(t));
    for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i].add(i < values.size() ? values[i] : not_a_number);
    if (time_->size() == chunk_size) write();
  }

  void offered(const UpdateRecord& record) override {
    if (failure_) return;
    try {
      measurements_[as_size(record.measurement)]->add(record);
    } catch (...) {
      failure_ = std::current_exception();
    }
  }

  void scored(const ErrorSeries& errors) {
    if (!errors_) errors_ = group_.add_group("errors");
    const auto base = time_base(errors);
    const auto [block, component] = component_of(errors);
    if (block)
      write_component(errors, *block, component, base);
    else
      write_scalar(errors, base);
  }

  void close() {
    tell_failure();
    if (time_) write();
    for (auto& measurement : measurements_) measurement->close();
  }

 private:
  struct TimeBase {
    int dimension = 0;
    std::vector<Time> t;
    std::string name;
  };
  /// The error components of a block, as one variable.
  struct BlockErrors {
    int values = -1, sigmas = -1;
    std::size_t base = 0;
  };

  void tell_failure() {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  void write() {
    const std::size_t records = time_->size();
    time_->write(first_);
    for (auto& column : columns_) column.write(first_);
    first_ += records;
  }

  void describe(int variable, const BlockInfo& block, const std::vector<Output>& outputs, bool is_sigma) {
    std::string what = block.name, comment;
    if (outputs.size() == 1) what += "." + outputs[0].name;
    for (const auto& output : outputs)
      if (!output.text.empty())
        comment += (comment.empty() ? "" : "; ") + (outputs.size() > 1 ? output.name + ": " : "") + output.text;
    group_.put_text(variable, "long_name", is_sigma ? what + ": 1-sigma of the estimate" : what);
    put_units(group_, variable, {outputs[0].unit, outputs[0].display_unit});
    group_.put_text(variable, "block", block.name);
    if (outputs.size() == 1) group_.put_text(variable, "output", outputs[0].name);
    put_if_any(group_, variable, "kind", block.declaration->kind);
    put_if_any(group_, variable, "frame", frame_of(block.declaration->kind));
    if (outputs.size() == 1) {
      const std::string standard = standard_name_of(block.declaration->kind, outputs[0].name);
      put_if_any(group_, variable, "standard_name",
                 standard.empty() || !is_sigma ? standard : standard + " standard_error");
    }
    if (is_sigma) return;
    put_if_any(group_, variable, "comment", comment);
    std::vector<signed char> angles;
    for (const auto& output : outputs) angles.push_back(output.is_angle);
    if (std::count(angles.begin(), angles.end(), 1) > 0) group_.put_bytes(variable, "is_angle", angles);
  }

  void add_variables(const BlockInfo& block, const std::string& name, const std::vector<Output>& outputs,
                     const std::vector<int>& dimensions, std::vector<Column<double>>& sigmas) {
    const auto chunks = growing_chunks(dimensions.size());
    const std::string value_name = names_.take(name), sigma_name = names_.take(name + "_sigma");
    const int value = group_.add_variable(value_name, NC_DOUBLE, dimensions, chunks);
    const int sigma = group_.add_variable(sigma_name, NC_DOUBLE, dimensions, chunks);
    describe(value, block, outputs, false);
    describe(sigma, block, outputs, true);
    group_.put_text(value, "ancillary_variables", sigma_name);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const int column = dimensions.size() > 1 ? static_cast<int>(i) : -1;
      columns_.emplace_back(group_, value, column);
      sigmas.emplace_back(group_, sigma, column);
    }
  }

  void add_block(const BlockInfo& block, std::vector<Column<double>>& sigmas) {
    const auto& outputs = block.declaration->outputs;
    if (!are_alike(outputs)) {
      for (const auto& output : outputs)
        add_variables(block, block.name + "_" + output.name, {output}, {time_dimension_}, sigmas);
      return;
    }
    std::vector<std::string> components;
    for (const auto& output : outputs) components.push_back(output.name);
    const int dimension = add_components(group_, names_.take(block.name + "_component"), components);
    add_variables(block, block.name, outputs, {time_dimension_, dimension}, sigmas);
  }

  /// Errors at the same times share them.
  std::size_t time_base(const ErrorSeries& errors) {
    for (std::size_t i = 0; i < bases_.size(); ++i)
      if (std::equal(bases_[i].t.begin(), bases_[i].t.end(), errors.t.begin(), errors.t.end())) return i;
    TimeBase base;
    base.name = error_names_.take(bases_.empty() ? "time" : "time_" + errors.name);
    // A dimension of no size would be one that grows.
    base.dimension = errors.t.empty() ? errors_->add_growing_dimension(base.name)
                                      : errors_->add_dimension(base.name, errors.t.size());
    base.t.assign(errors.t.begin(), errors.t.end());
    const int id = errors_->add_variable(base.name, NC_DOUBLE, {base.dimension}, chunks_of(errors.t.size(), 1));
    errors_->put_text(id, "units", "s");
    errors_->put_text(id, "long_name", "time of the reference");
    errors_->put_text(id, "axis", "T");
    std::vector<double> s;
    for (std::size_t first = 0; first < errors.t.size(); first += chunk_size) {
      s.clear();
      for (std::size_t i = first; i < std::min(first + chunk_size, errors.t.size()); ++i)
        s.push_back(nearest_seconds(errors.t[i]));
      const std::size_t count = s.size();
      errors_->write(id, &first, &count, s.data());
    }
    bases_.push_back(std::move(base));
    return bases_.size() - 1;
  }

  static std::vector<std::size_t> chunks_of(std::size_t size, std::size_t rank) {
    auto chunks = growing_chunks(rank);
    if (size > 0) chunks[0] = std::min(chunks[0], size);
    return chunks;
  }

  /// The block whose error component it is, and which.
  std::pair<const BlockInfo*, int> component_of(const ErrorSeries& errors) const {
    for (const auto& block : info_.blocks) {
      const auto& components = block.declaration->error;
      const bool is_one_unit = std::all_of(components.begin(), components.end(),
                                           [&](const NamedUnit& other) { return other.unit == components[0].unit; });
      if (components.size() < 2 || !is_one_unit) continue;
      for (std::size_t i = 0; i < components.size(); ++i)
        if (errors.name == block.name + "." + components[i].name && errors.unit == components[i].unit)
          return {&block, static_cast<int>(i)};
    }
    return {nullptr, -1};
  }

  int add_error_variable(const std::string& name, const std::vector<int>& dimensions, const ErrorSeries& errors,
                         const std::string& long_name) {
    const int id = errors_->add_variable(name, NC_DOUBLE, dimensions, chunks_of(errors.t.size(), dimensions.size()));
    errors_->fill_with_nan(id);
    errors_->put_text(id, "long_name", long_name);
    put_units(*errors_, id, {errors.unit, errors.display_unit});
    return id;
  }

  void write_scalar(const ErrorSeries& errors, std::size_t base) {
    const std::string name = error_names_.take(errors.name);
    const int id = add_error_variable(name, {bases_[base].dimension}, errors, describe_error(errors.name));
    errors_->put_text(id, "series", errors.name);
    write_values(id, -1, errors.values);
    if (errors.sigma.empty()) return;
    const std::string sigma_name = error_names_.take(errors.name + "_sigma");
    const int sigma = add_error_variable(sigma_name, {bases_[base].dimension}, errors,
                                         errors.name + ": what the filter thought of the error, 1-sigma");
    errors_->put_text(id, "ancillary_variables", sigma_name);
    write_values(sigma, -1, errors.sigma);
  }

  void write_component(const ErrorSeries& errors, const BlockInfo& block, int component, std::size_t base) {
    auto& own = block_errors_[&block];
    if (own.values < 0) {
      own = add_block_errors(errors, block, base);
    } else if (own.base != base) {
      write_scalar(errors, base);
      return;
    }
    write_values(own.values, component, errors.values);
    if (own.sigmas >= 0) write_values(own.sigmas, component, errors.sigma);
  }

  BlockErrors add_block_errors(const ErrorSeries& errors, const BlockInfo& block, std::size_t base) {
    BlockErrors own;
    own.base = base;
    std::vector<std::string> components;
    for (const auto& component : block.declaration->error) components.push_back(component.name);
    const int dimension = add_components(*errors_, error_names_.take(block.name + "_component"), components);
    const std::vector<int> dimensions{bases_[base].dimension, dimension};
    const auto add = [&](const std::string& name, const std::string& long_name) {
      const int id = add_error_variable(name, dimensions, errors, long_name);
      errors_->put_text(id, "block", block.name);
      put_if_any(*errors_, id, "kind", block.declaration->kind);
      put_if_any(*errors_, id, "frame", error_frame_of(components));
      return id;
    };
    own.values = add(error_names_.take(block.name), describe_error(block.name));
    errors_->put_text(own.values, "series", block.name);
    if (errors.sigma.empty()) return own;
    const std::string sigma_name = error_names_.take(block.name + "_sigma");
    own.sigmas = add(sigma_name, block.name + ": what the filter thought of the error, 1-sigma");
    errors_->put_text(own.values, "ancillary_variables", sigma_name);
    return own;
  }

  static std::string describe_error(const std::string& name) {
    const auto ends_with = [&](std::string_view end) { return name.ends_with(end); };
    if (ends_with(".nees")) return name + ": normalized estimation error squared";
    if (ends_with(".noise")) return name + ": measurement noise as the noise estimator has it, 1-sigma";
    return name + ": truth - estimate";
  }

  void write_values(int variable, int column, std::span<const double> values) {
    const std::size_t start[] = {0, column < 0 ? 0 : as_size(column)};
    const std::size_t count[] = {values.size(), 1};
    if (!values.empty()) errors_->write(variable, start, count, values.data());
  }

  nc::Group group_;
  const FilterInfo& info_;
  Names names_, error_names_;
  int time_dimension_ = 0;
  std::optional<Column<double>> time_;
  std::vector<Column<double>> columns_;
  std::size_t first_ = 0;  // record of the open chunk
  std::vector<std::unique_ptr<Measurement>> measurements_;
  std::optional<nc::Group> errors_;
  std::vector<TimeBase> bases_;
  std::map<const BlockInfo*, BlockErrors> block_errors_;
  std::exception_ptr failure_;
};

struct RunWriter::Contents {
  Contents(const std::filesystem::path& path, const Composition& composition, const Json& provenance)
      : file(nc::File::create(path)) {
    write_provenance(file.root(), "run", composition.config(), provenance);
    Names names;
    for (const char* taken : {"config", "plugin", "plugin_version", "plugin_path"}) names.take(taken);
    for (const auto& filter : composition.filters())
      filters.push_back(std::make_unique<Filter>(file.root().add_group(names.take(filter.name)), filter));
  }
  nc::File file;
  std::vector<std::unique_ptr<Filter>> filters;
};

RunWriter::RunWriter(const std::filesystem::path& path, const Composition& composition, const Json& provenance) {
  guarded([&] { contents_ = std::make_unique<Contents>(path, composition, provenance); });
}

RunWriter::~RunWriter() = default;

void RunWriter::begin(int filter, const std::string&, const std::vector<RecordColumn>& columns) {
  guarded([&] { contents_->filters[as_size(filter)]->begin(columns); });
}

void RunWriter::record(int filter, Time t, std::span<const double> values) {
  guarded([&] { contents_->filters[as_size(filter)]->record(t, values); });
}

StepTape* RunWriter::tape(int filter) { return contents_->filters[as_size(filter)].get(); }

void RunWriter::scored(int filter, const ErrorSeries& errors) {
  guarded([&] { contents_->filters[as_size(filter)]->scored(errors); });
}

void RunWriter::close() {
  guarded([&] {
    for (auto& filter : contents_->filters) filter->close();
    contents_->filters.clear();
    contents_->file.close();
  });
}

}  // namespace binnacle::results
