// SPDX-License-Identifier: Apache-2.0
// What a Composition shows of its filters.
#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

template <class Base>
BoundInfo<Base> bound_info(const Catalog& catalog, const auto& plan, const std::shared_ptr<const Base>& object) {
  return {plan.name, catalog.find(role_of<Base>(), plan.type), object, plan.ports};
}

BlockInfo block_info(const BlockPlan& block) {
  BlockInfo info{block.name,  block.type,   block.block, &block.declaration(), block.stored_offset,
                 block.first, block.active, {},          block.initial.value};
  for (const Use use : block.use)
    info.use.push_back(use == Use::estimated ? "estimated" : use == Use::considered ? "considered" : "frozen");
  return info;
}

/// The block itself, or for a derived value the block of the filter with the same error components; −1: none.
int block_like(const FilterPlan& filter, int value) {
  if (filter.is_block(value)) return value;
  const auto kind_of = [](const BlockPlan& block) { return block.declaration().kind; };
  return index_of(filter.blocks, filter.derived_at(value).derived->declaration().kind, kind_of);
}

std::vector<RowGroupInfo> row_groups(const FilterPlan& filter, const MeasurementPlan& measurement) {
  std::vector<RowGroupInfo> all;
  for (const auto& part : measurement.parts) {
    const auto& groups = part.model->declaration().groups;
    if (groups.empty()) all.push_back({part.name, "", "", -1});
    for (const auto& group : groups) {
      const std::string name = groups.size() < 2              ? part.name
                               : measurement.parts.size() > 1 ? part.name + "." + group.name
                                                              : group.name;
      const int like = group.port < 0 ? -1 : block_like(filter, part.ports[as_size(group.port)]);
      const auto& unit = like < 0 ? group.unit : filter.blocks[as_size(like)].declaration().error.front().unit;
      all.push_back({name, unit, group.name, like});
    }
  }
  return all;
}

MeasurementInfo measurement_info(const Catalog& catalog, const FilterPlan& filter, const MeasurementPlan& measurement) {
  MeasurementInfo info;
  info.name = measurement.name;
  info.channel = measurement.channel;
  info.max_rows = measurement.max_rows;
  for (const auto& part : measurement.parts) info.parts.push_back(bound_info(catalog, part, part.model));
  info.groups = row_groups(filter, measurement);
  for (int b = 0; b < count_of(filter.blocks); ++b) {
    const auto& block = filter.blocks[as_size(b)];
    if (!block.active.empty() && index_of(measurement.columns, block.first) >= 0) info.blocks.push_back(b);
  }
  if (measurement.noise)
    info.noise = {measurement.name, catalog.find(Role::noise_estimator, measurement.noise_type), measurement.noise};
  info.recovers = measurement.recover_after > 0;
  info.is_watched = measurement.is_watched;
  if (measurement.gate > 0)
    info.gate = {measurement.gate, gate_unit_names[static_cast<int>(measurement.gate_unit)],
                 measurement.gate_limit[measurement.gate_unit == GateUnit::row ? 1 : as_size(info.max_rows)]};
  info.update.type = UpdatePlan::names[static_cast<int>(measurement.update.type)];
  if (measurement.update.type == UpdatePlan::Type::iterated) {
    info.update.max = measurement.update.most;
    info.update.tolerance = measurement.update.tolerance;
  }
  return info;
}

}  // namespace

void FilterComposer::describe() {
  info.name = plan.name;
  info.dof = plan.n;
  info.stored_size = plan.stored_size;
  info.input_channel = plan.input_channel;
  info.covariance = covariance_names[static_cast<int>(plan.covariance_kind)];
  info.is_unscented = plan.is_unscented;
  info.history = plan.history;
  info.history_steps = plan.history_steps;
  for (const auto& block : plan.blocks) info.blocks.push_back(block_info(block));
  const Catalog& catalog = composer.plan().catalog;
  for (const auto& derived : plan.derived) info.derived.push_back(bound_info(catalog, derived, derived.derived));
  for (const auto& process : plan.processes)
    info.processes.push_back({bound_info(catalog, process, process.model), process.van_loan_group});
  for (const auto& measurement : plan.measurements)
    info.measurements.push_back(measurement_info(catalog, plan, measurement));
  for (const auto& initial : plan.initial)
    if (initial.is_of_start) info.starts_when.push_back({initial.channel, initial.max_age});
}

}  // namespace binnacle::internal::compose
