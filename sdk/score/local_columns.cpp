// SPDX-License-Identifier: Apache-2.0
#include "local_columns.hpp"

#include "binnacle/state_block.hpp"

namespace binnacle::score {

namespace {

bool is_geodetic(const std::vector<Output>& outputs) {
  const auto is = [&](std::size_t i, const char* name, const char* unit) {
    return outputs[i].name == name && outputs[i].unit == unit;
  };
  return outputs.size() == 3 && is(0, "lat", "rad") && is(1, "lon", "rad") && is(2, "height", "m");
}

}  // namespace

LocalColumns::LocalColumns(const FilterInfo& filter, const std::optional<geodesy::LocalAxes>& axes) {
  if (!axes) return;
  axes_ = *axes;
  std::size_t first = 0;
  for (const BlockInfo& block : filter.blocks) {
    const auto& outputs = block.declaration->outputs;
    if (is_geodetic(outputs)) {
      positions_.push_back(first);
      for (const char* axis : {"north", "east", "down"}) columns_.push_back({block.name + ".local_" + axis, "m"});
    }
    first += outputs.size();
  }
}

void LocalColumns::read(const double* outputs, double* values) const {
  for (const std::size_t first : positions_) {
    const Eigen::Vector3d lla = Eigen::Map<const Eigen::Vector3d>(outputs + first);
    Eigen::Map<Eigen::Vector3d> local(values);
    local = axes_.ned_from_lla(lla);
    values += 3;
  }
}

}  // namespace binnacle::score
