// SPDX-License-Identifier: Apache-2.0
#include "binnacle/parts.hpp"

#include <algorithm>
#include <stdexcept>

#include "compose/composition_plan.hpp"

namespace binnacle::parts {

namespace {

using namespace compose;

template <class Plans>
const auto& named(const Plans& plans, std::string_view name) {
  const auto found = std::ranges::find(plans, name, [](const auto& plan) { return std::string_view(plan.name); });
  if (found == plans.end()) throw std::out_of_range("the composition has no part '" + std::string(name) + "'");
  return *found;
}

const FilterPlan& filter_named(const Composition& composition, std::string_view name) {
  return named(composition.plan().filters, name);
}

Value value_of(const BlockPlan& plan) { return {plan.name, plan.block, nullptr, plan.initial.value}; }

template <class Model>
Part<Model> part_of(const Composition& composition, const FilterPlan& filter, const auto& plan,
                    const std::shared_ptr<const Model>& model) {
  Part<Model> part{composition.catalog().find(role_of<Model>(), plan.type), model, {}};
  for (const int port : plan.ports)
    part.ports.push_back(port < 0 ? Value()
                         : filter.is_block(port)
                             ? value_of(filter.blocks[as_size(port)])
                             : Value{filter.derived_at(port).name, nullptr, filter.derived_at(port).derived, {}});
  return part;
}

}  // namespace

Value block(const Composition& composition, std::string_view filter, std::string_view name) {
  return value_of(named(filter_named(composition, filter).blocks, name));
}

Part<ProcessModel> process(const Composition& composition, std::string_view filter, std::string_view name) {
  const FilterPlan& owner = filter_named(composition, filter);
  const ProcessPlan& plan = named(owner.processes, name);
  return part_of(composition, owner, plan, plan.model);
}

Part<DerivedBlock> derived(const Composition& composition, std::string_view filter, std::string_view name) {
  const FilterPlan& owner = filter_named(composition, filter);
  const DerivedPlan& plan = named(owner.derived, name);
  return part_of(composition, owner, plan, plan.derived);
}

Part<MeasurementModel> measurement(const Composition& composition, std::string_view filter, std::string_view name,
                                   std::string_view part) {
  const FilterPlan& owner = filter_named(composition, filter);
  const MeasurementPlan& whole = named(owner.measurements, name);
  const PartPlan& plan = part.empty() ? whole.parts.front() : named(whole.parts, part);
  return part_of(composition, owner, plan, plan.model);
}

NoisePart noise(const Composition& composition, std::string_view filter, std::string_view measurement) {
  const MeasurementPlan& plan = named(filter_named(composition, filter).measurements, measurement);
  if (!plan.noise) throw std::out_of_range("'" + plan.name + "' has no noise estimator");
  return {composition.catalog().find(Role::noise_estimator, plan.noise_type), plan.noise, plan.max_rows};
}

Part<Source> source(const Composition& composition, std::string_view name) {
  const SourcePlan& plan = named(composition.plan().sources, name);
  return {plan.type, plan.source, {}};
}

Part<Transform> transform(const Composition& composition, std::string_view name) {
  const TransformPlan& plan = named(composition.plan().transforms, name);
  return {plan.type, plan.transform, {}};
}

}  // namespace binnacle::parts
