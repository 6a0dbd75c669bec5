// SPDX-License-Identifier: Apache-2.0
#include "provenance.hpp"
#include "read_files.hpp"

namespace binnacle::results {

namespace {

std::vector<double> read_time(nc::Group group, const std::string& name) {
  const auto variable = group.variable(name);
  if (!variable) throw nc::Failure("its group '" + group.name() + "' has no variable '" + name + "'");
  return group.read<double>(*variable);
}

int variable_of(nc::Group group, const std::string& name) {
  if (const auto variable = group.variable(name)) return *variable;
  throw nc::Failure("its group '" + group.name() + "' has no variable '" + name + "'");
}

/// One value for each time: whoever has them takes them by one index.
template <class T>
std::vector<T> read_series(nc::Group group, int variable, std::size_t times) {
  const auto sizes = group.shape(variable);
  if (sizes.size() != 1 || sizes[0] != times)
    throw nc::Failure("its variable '" + group.variable_name(variable) + "' has another shape than its times");
  return group.read<T>(variable);
}

template <class T>
std::vector<T> read_column(nc::Group group, int variable, std::size_t column, std::size_t times) {
  auto values = group.read_column<T>(variable, column);
  if (values.size() != times)
    throw nc::Failure("its variable '" + group.variable_name(variable) + "' has another shape than its times");
  return values;
}

/// Names of the columns of a variable (rows, columns).
std::vector<std::string> components_of(nc::Group group, int variable) {
  const auto dimensions = group.dimensions(variable);
  if (dimensions.size() != 2)
    throw nc::Failure("its variable '" + group.variable_name(variable) + "' has no components");
  return group.read_texts(variable_of(group, group.dimension_name(dimensions[1])));
}

std::string display_unit_of(nc::Group group, int variable) {
  const auto shown = group.text(variable, "display_units");
  return shown.empty() ? group.text(variable, "units") : shown;
}

/// Of the variable named by "ancillary_variables": its own, or the column.
std::vector<double> values_of(nc::Group group, int variable, int column, std::size_t times) {
  return column < 0 ? read_series<double>(group, variable, times)
                    : read_column<double>(group, variable, static_cast<std::size_t>(column), times);
}

void read_estimates(nc::Group group, int variable, FilterResults& filter) {
  const bool is_single = group.dimensions(variable).size() == 1;
  const auto names = is_single ? std::vector{group.text(variable, "output")} : components_of(group, variable);
  const auto angles = group.bytes(variable, "is_angle");
  const int sigma = variable_of(group, group.text(variable, "ancillary_variables"));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int column = is_single ? -1 : static_cast<int>(i);
    filter.estimates.push_back({group.text(variable, "block"), names[i], group.text(variable, "units"),
                                display_unit_of(group, variable), i < angles.size() && angles[i] != 0,
                                values_of(group, variable, column, filter.t.size()),
                                values_of(group, sigma, column, filter.t.size()), group.text(variable, "kind")});
  }
}

void read_errors(nc::Group group, FilterResults& filter) {
  for (int variable = 0; variable < group.variables(); ++variable) {
    if (!group.has(variable, "series")) continue;
    const auto dimensions = group.dimensions(variable);
    const std::string series = group.text(variable, "series"), sigma = group.text(variable, "ancillary_variables");
    const bool is_single = dimensions.size() == 1;
    const auto names = is_single ? std::vector{series} : components_of(group, variable);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const int column = is_single ? -1 : static_cast<int>(i);
      const auto t = read_time(group, group.dimension_name(dimensions[0]));
      filter.errors.push_back(
          {is_single ? series : series + "." + names[i], group.text(variable, "units"),
           display_unit_of(group, variable), t, values_of(group, variable, column, t.size()),
           sigma.empty() ? std::vector<double>{} : values_of(group, variable_of(group, sigma), column, t.size()),
           group.has(variable, "norm"), !is_single});
    }
  }
}

/// Rows of one group, slot by slot: the first of each sample, the second, …
struct Slots {
  std::vector<std::vector<double>> residual, sigma, noise;
  std::vector<std::vector<std::int64_t>> key;
};

Slots read_slots(nc::Group group, int residual, std::size_t times) {
  const std::string suffix = group.variable_name(residual).substr(std::string("residual").size());
  const int sigma = variable_of(group, "residual_sigma" + suffix), noise = variable_of(group, "noise" + suffix),
            key = variable_of(group, "key" + suffix);
  Slots slots;
  const auto shape = group.shape(residual);
  for (std::size_t s = 0; shape.size() == 2 && s < shape[1]; ++s) {
    slots.residual.push_back(read_column<double>(group, residual, s, times));
    slots.sigma.push_back(read_column<double>(group, sigma, s, times));
    slots.noise.push_back(read_column<double>(group, noise, s, times));
    slots.key.push_back(read_column<std::int64_t>(group, key, s, times));
  }
  return slots;
}

void add_rows(const std::vector<Slots>& groups, std::size_t sample, Updates& updates) {
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (std::size_t s = 0; s < groups[g].key.size(); ++s) {
      if (groups[g].key[s][sample] == NC_FILL_INT64) continue;
      updates.group.push_back(static_cast<std::int32_t>(g));
      updates.key.push_back(groups[g].key[s][sample]);
      updates.residual.push_back(groups[g].residual[s][sample]);
      updates.sigma.push_back(groups[g].sigma[s][sample]);
      updates.noise.push_back(groups[g].noise[s][sample]);
    }
}

Updates read_updates(nc::Group group) {
  Updates updates;
  updates.measurement = group.text(NC_GLOBAL, "measurement");
  updates.t = read_time(group, "time");
  const std::size_t times = updates.t.size();
  for (const signed char outcome : read_series<signed char>(group, variable_of(group, "outcome"), times)) {
    if (outcome < 0 || outcome >= outcome_count)
      throw nc::Failure("its group '" + group.name() + "' has an outcome unknown");
    updates.outcome.push_back(static_cast<Outcome>(outcome));
  }
  const auto texts = group.read_texts(variable_of(group, "reason_text"));
  for (const std::int32_t reason : read_series<std::int32_t>(group, variable_of(group, "reason"), times)) {
    if (reason < 0 || static_cast<std::size_t>(reason) >= texts.size())
      throw nc::Failure("its group '" + group.name() + "' has a reason unknown");
    updates.reason.push_back(texts[static_cast<std::size_t>(reason)]);
  }
  updates.nis = read_series<double>(group, variable_of(group, "nis"), times);
  updates.rows = read_series<std::int32_t>(group, variable_of(group, "rows"), times);
  std::vector<Slots> groups;
  for (int variable = 0; variable < group.variables(); ++variable) {
    const std::string name = group.variable_name(variable);
    if (!name.starts_with("residual") || !group.has(variable, "ancillary_variables")) continue;
    updates.groups.push_back({group.text(variable, "row_group"), group.text(variable, "units")});
    groups.push_back(read_slots(group, variable, times));
  }
  for (std::size_t sample = 0; sample < updates.t.size(); ++sample) {
    const std::size_t before = updates.key.size();
    add_rows(groups, sample, updates);
    if (updates.key.size() - before != static_cast<std::size_t>(updates.rows[sample]))
      throw nc::Failure("its group '" + group.name() + "' has other rows than it declares");
  }
  return updates;
}

FilterResults read_filter(nc::Group group) {
  FilterResults filter;
  filter.name = group.text(NC_GLOBAL, "filter");
  filter.t = read_time(group, "time");
  for (int variable = 0; variable < group.variables(); ++variable)
    if (group.has(variable, "block") && group.has(variable, "ancillary_variables"))
      read_estimates(group, variable, filter);
    else if (group.has(variable, "column"))
      filter.others.push_back({group.text(variable, "column"), group.text(variable, "units"),
                               read_series<double>(group, variable, filter.t.size())});
  if (const auto errors = group.group("errors")) read_errors(*errors, filter);
  if (const auto measurements = group.group("measurements"))
    for (const nc::Group measurement : measurements->groups()) filter.updates.push_back(read_updates(measurement));
  return filter;
}

}  // namespace

RunResults read_run(const nc::File& file) {
  RunResults run;
  read_provenance(file.root(), "run", run.config, run.provenance);
  for (const nc::Group filter : file.root().groups()) run.filters.push_back(read_filter(filter));
  return run;
}

}  // namespace binnacle::results
