// SPDX-License-Identifier: Apache-2.0
#include "results/run_writer.hpp"

#include <algorithm>
#include <exception>
#include <optional>

#include "attributes.hpp"
#include "binnacle/state_block.hpp"
#include "columns.hpp"
#include "error_writer.hpp"
#include "frames.hpp"
#include "measurement_writer.hpp"
#include "names.hpp"
#include "netcdf.hpp"
#include "provenance.hpp"

namespace binnacle::results {

namespace {

/// Outputs that may be columns of one variable.
bool are_alike(const std::vector<Output>& outputs) {
  return outputs.size() > 1 && std::all_of(outputs.begin(), outputs.end(), [&](const Output& output) {
           return output.unit == outputs[0].unit && output.display_unit == outputs[0].display_unit;
         });
}

/// What a recorded column beyond the blocks' own is: of an implied state, or of a noise estimator.
std::string describe_column(const std::string& name) {
  if (name.ends_with(".noise")) return describe_noise(name);
  const std::size_t local = name.rfind(".local_");
  if (local != name.npos)
    return name.substr(0, local) + ": " + name.substr(local + 7) + " of the config's origin, local Cartesian axes";
  return name + (name.ends_with(".sigma") ? ": the filter's 1-sigma of the implied state"
                                          : ": implied state, a block as one measurement gives it");
}

template <class Action>
void guarded(Action&& action) {
  try {
    action();
  } catch (const nc::Failure& failure) {
    throw WriteError(failure.what());
  }
}

}  // namespace

class RunWriter::Filter : public StepObserver {
 public:
  Filter(nc::Group group, const FilterInfo& info, int level, WriterThread& thread)
      : group_(group), info_(info), level_(level) {
    group.put_text(NC_GLOBAL, "filter", info.name);
    names_.take("errors");
    names_.take("measurements");
    if (info.measurements.empty()) return;
    const nc::Group all = group.add_group("measurements");
    Names names;
    for (const auto& measurement : info.measurements)
      measurements_.push_back(
          std::make_unique<MeasurementWriter>(all.add_group(names.take(measurement.name)), measurement, level, thread));
  }

  /// Columns come as the kernel records them: outputs block by block, their 1-σ in the same order, implied states, adapted noise.
  void begin(const std::vector<score::RecordColumn>& columns) { recorded_ = columns; }

  void write(const ColumnBlock& rows) {
    if (!is_defined_) define(rows.rows());
    write_rows(group_, time_, first_, rows.t());
    for (std::size_t i = 0; i < columns_.size(); ++i) write_rows(group_, columns_[i], first_, rows.column(i));
    first_ += rows.rows();
  }

  void offered(const UpdateRecord& record) override {
    if (failure_) return;
    try {
      measurements_[as_size(record.measurement)]->add(record);
    } catch (...) {
      failure_ = std::current_exception();
    }
  }

  void scored(const score::ErrorSeries& errors) {
    if (!errors_) errors_.emplace(group_.add_group("errors"), info_, level_);
    errors_->add(errors);
  }

  void flush() {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    for (auto& measurement : measurements_) measurement->flush();
  }

  void close() {
    if (!is_defined_ && !recorded_.empty()) define(1);
    for (auto& measurement : measurements_) measurement->close();
  }

 private:
  /// As soon as it is known how long a chunk may be: a short run's would be mostly empty.
  void define(std::size_t rows) {
    is_defined_ = true;
    rows_of_chunk_ = rows;
    time_dimension_ = group_.add_growing_dimension(names_.take("time"));
    time_ = {add_time(group_, "time", time_dimension_, growing(1, rows, level_), "time of the estimates")};
    std::vector<Column> sigmas;
    for (const auto& block : info_.blocks) add_block(block, sigmas);
    columns_.insert(columns_.end(), sigmas.begin(), sigmas.end());
    for (std::size_t i = columns_.size(); i < recorded_.size(); ++i) {
      const int id =
          group_.add_variable(names_.take(recorded_[i].name), NC_DOUBLE, {time_dimension_}, growing(1, rows, level_));
      group_.put_text(id, "long_name", describe_column(recorded_[i].name));
      group_.put_text(id, "column", recorded_[i].name);
      put_units(group_, id, {recorded_[i].unit, ""});
      columns_.push_back({id});
    }
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
                     const std::vector<int>& dimensions, std::vector<Column>& sigmas) {
    const auto storage = growing(dimensions.size(), rows_of_chunk_, level_);
    const std::string value_name = names_.take(name), sigma_name = names_.take(name + "_sigma");
    const int value = group_.add_variable(value_name, NC_DOUBLE, dimensions, storage);
    const int sigma = group_.add_variable(sigma_name, NC_DOUBLE, dimensions, storage);
    describe(value, block, outputs, false);
    describe(sigma, block, outputs, true);
    group_.put_text(value, "ancillary_variables", sigma_name);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const int column = dimensions.size() > 1 ? static_cast<int>(i) : -1;
      columns_.push_back({value, column});
      sigmas.push_back({sigma, column});
    }
  }

  void add_block(const BlockInfo& block, std::vector<Column>& sigmas) {
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

  nc::Group group_;
  const FilterInfo& info_;
  int level_;
  std::vector<score::RecordColumn> recorded_;
  Names names_;
  bool is_defined_ = false;
  std::size_t rows_of_chunk_ = 1;
  int time_dimension_ = 0;
  Column time_;
  std::vector<Column> columns_;
  std::size_t first_ = 0;  // row that comes next
  std::vector<std::unique_ptr<MeasurementWriter>> measurements_;
  std::optional<ErrorWriter> errors_;
  std::exception_ptr failure_;
};

struct RunWriter::Contents {
  Contents(const std::filesystem::path& path, const Composition& composition, const Json& provenance, int level,
           WriterThread& thread)
      : file(nc::File::create(path)) {
    write_provenance(file.root(), "run", Json::parse(composition.config()), provenance);
    Names names;
    for (const char* taken : {"config", "plugin", "plugin_version", "plugin_path"}) names.take(taken);
    for (const auto& filter : score::filters_of(composition))
      filters.push_back(
          std::make_unique<Filter>(file.root().add_group(names.take(filter.name)), filter, level, thread));
  }
  nc::File file;
  std::vector<std::unique_ptr<Filter>> filters;
};

RunWriter::RunWriter(const std::filesystem::path& path, const Composition& composition, const Json& provenance,
                     int level, WriterThread& thread)
    : thread_(thread) {
  guarded([&] { contents_ = std::make_unique<Contents>(path, composition, provenance, level, thread); });
  thread_.post(0, nc::keep_quiet);
}

RunWriter::~RunWriter() = default;

void RunWriter::begin(int filter, const std::vector<score::RecordColumn>& columns) {
  contents_->filters[as_size(filter)]->begin(columns);
}

void RunWriter::write(int filter, const ColumnBlock& rows) {
  nc::require_memory(nc::memory_of_rows);
  guarded([&] { contents_->filters[as_size(filter)]->write(rows); });
}

StepObserver* RunWriter::step_observer(int filter) { return contents_->filters[as_size(filter)].get(); }

/// Its spans end with the call, so that this waits.
void RunWriter::scored(int filter, const score::ErrorSeries& errors) {
  thread_.post(0, [&] { guarded([&] { contents_->filters[as_size(filter)]->scored(errors); }); });
  thread_.finish();
}

void RunWriter::close() {
  for (auto& filter : contents_->filters) filter->flush();
  thread_.post(0, [&] {
    guarded([&] {
      for (auto& filter : contents_->filters) filter->close();
      contents_->filters.clear();
      contents_->file.close();
    });
  });
  thread_.finish();
}

}  // namespace binnacle::results
