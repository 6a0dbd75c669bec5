// SPDX-License-Identifier: Apache-2.0
#include "filter/residual_rows.hpp"

namespace binnacle::filter {

namespace {

/// The block itself, or for a derived value the block of the filter with the same error components.
const BlockPlan* block_like(const FilterPlan& filter, int value) {
  if (value < 0) return nullptr;
  if (filter.is_block(value)) return &filter.blocks[as_size(value)];
  const auto& kind = filter.derived_at(value).derived->declaration().kind;
  for (const auto& block : filter.blocks)
    if (block.declaration().kind == kind) return &block;
  return nullptr;
}

}  // namespace

std::vector<ResidualRows> residual_rows_of(const FilterPlan& filter, const MeasurementPlan& measurement) {
  std::vector<ResidualRows> all;
  for (const auto& part : measurement.parts) {
    const auto& groups = part.model->declaration().groups;
    if (groups.empty()) all.push_back({part.name, "", "", nullptr});
    for (const auto& group : groups) {
      const std::string name = groups.size() < 2              ? part.name
                               : measurement.parts.size() > 1 ? part.name + "." + group.name
                                                              : group.name;
      const BlockPlan* like = group.port < 0 ? nullptr : block_like(filter, part.ports[as_size(group.port)]);
      all.push_back({name, group.name, like ? like->declaration().error.front().unit : group.unit, like});
    }
  }
  return all;
}

}  // namespace binnacle::filter
