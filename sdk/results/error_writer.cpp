// SPDX-License-Identifier: Apache-2.0
#include "error_writer.hpp"

#include <algorithm>
#include <string_view>

#include "attributes.hpp"
#include "binnacle/state_block.hpp"
#include "frames.hpp"
#include "results/run_writer.hpp"

namespace binnacle::results {

namespace {

nc::Storage storage_of(std::size_t size, std::size_t rank, int level) {
  return growing(rank, std::clamp<std::size_t>(size, 1, chunk_size), level);
}

std::string describe_error(const std::string& name) {
  const auto ends_with = [&](std::string_view end) { return name.ends_with(end); };
  if (ends_with(".nees")) return name + ": normalized estimation error squared";
  if (ends_with(".noise")) return describe_noise(name);
  return name + ": truth - estimate";
}

}  // namespace

std::pair<const BlockInfo*, int> component_of(const FilterInfo& filter, const score::ErrorSeries& errors) {
  for (const auto& block : filter.blocks) {
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

bool is_norm(const FilterInfo& filter, const std::string& series) {
  for (const auto& block : filter.blocks)
    for (const auto& norm : block.declaration->norms)
      if (series == block.name + "." + norm.name) return true;
  return false;
}

void ErrorWriter::add(const score::ErrorSeries& errors) {
  const auto base = time_base(errors);
  const auto [block, component] = component_of(info_, errors);
  if (block)
    write_component(errors, *block, component, base);
  else
    write_scalar(errors, base);
}

/// Errors at the same times share them.
std::size_t ErrorWriter::time_base(const score::ErrorSeries& errors) {
  for (std::size_t i = 0; i < bases_.size(); ++i)
    if (std::equal(bases_[i].t.begin(), bases_[i].t.end(), errors.t.begin(), errors.t.end())) return i;
  TimeBase base;
  base.name = names_.take(bases_.empty() ? "time" : "time_" + errors.name);
  // A dimension of no size would be one that grows.
  base.dimension =
      errors.t.empty() ? group_.add_growing_dimension(base.name) : group_.add_dimension(base.name, errors.t.size());
  base.t.assign(errors.t.begin(), errors.t.end());
  const int id = group_.add_variable(base.name, NC_DOUBLE, {base.dimension}, storage_of(errors.t.size(), 1, level_));
  group_.put_text(id, "units", "s");
  group_.put_text(id, "long_name", "time of the reference");
  group_.put_text(id, "axis", "T");
  std::vector<double> s;
  for (std::size_t first = 0; first < errors.t.size(); first += chunk_size) {
    s.clear();
    for (std::size_t i = first; i < std::min(first + chunk_size, errors.t.size()); ++i)
      s.push_back(nearest_seconds(errors.t[i]));
    const std::size_t count = s.size();
    group_.write(id, &first, &count, s.data());
  }
  bases_.push_back(std::move(base));
  return bases_.size() - 1;
}

int ErrorWriter::add_variable(const std::string& name, const std::vector<int>& dimensions,
                              const score::ErrorSeries& errors, const std::string& long_name) {
  const int id =
      group_.add_variable(name, NC_DOUBLE, dimensions, storage_of(errors.t.size(), dimensions.size(), level_));
  group_.fill_with_nan(id);
  group_.put_text(id, "long_name", long_name);
  put_units(group_, id, {errors.unit, errors.display_unit});
  return id;
}

void ErrorWriter::write_scalar(const score::ErrorSeries& errors, std::size_t base) {
  const std::string name = names_.take(errors.name);
  const int id = add_variable(name, {bases_[base].dimension}, errors, describe_error(errors.name));
  group_.put_text(id, "series", errors.name);
  write_values(id, -1, errors.values);
  if (is_norm(info_, errors.name)) group_.put_text(id, "norm", "length of the error, never negative");
  if (errors.sigma.empty()) return;
  const std::string sigma_name = names_.take(errors.name + "_sigma");
  const int sigma =
      add_variable(sigma_name, {bases_[base].dimension}, errors, errors.name + ": the filter's 1-sigma of the error");
  group_.put_text(id, "ancillary_variables", sigma_name);
  write_values(sigma, -1, errors.sigma);
}

void ErrorWriter::write_component(const score::ErrorSeries& errors, const BlockInfo& block, int component,
                                  std::size_t base) {
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

ErrorWriter::BlockErrors ErrorWriter::add_block_errors(const score::ErrorSeries& errors, const BlockInfo& block,
                                                       std::size_t base) {
  BlockErrors own;
  own.base = base;
  std::vector<std::string> components;
  for (const auto& component : block.declaration->error) components.push_back(component.name);
  const int dimension = add_components(group_, names_.take(block.name + "_component"), components);
  const std::vector<int> dimensions{bases_[base].dimension, dimension};
  const auto add = [&](const std::string& name, const std::string& long_name) {
    const int id = add_variable(name, dimensions, errors, long_name);
    group_.put_text(id, "block", block.name);
    put_if_any(group_, id, "kind", block.declaration->kind);
    put_if_any(group_, id, "frame", error_frame_of(components));
    return id;
  };
  own.values = add(names_.take(block.name), describe_error(block.name));
  group_.put_text(own.values, "series", block.name);
  if (errors.sigma.empty()) return own;
  const std::string sigma_name = names_.take(block.name + "_sigma");
  own.sigmas = add(sigma_name, block.name + ": the filter's 1-sigma of the error");
  group_.put_text(own.values, "ancillary_variables", sigma_name);
  return own;
}

void ErrorWriter::write_values(int variable, int column, std::span<const double> values) {
  const std::size_t start[] = {0, column < 0 ? 0 : as_size(column)};
  const std::size_t count[] = {values.size(), 1};
  if (!values.empty()) group_.write(variable, start, count, values.data());
}

}  // namespace binnacle::results
