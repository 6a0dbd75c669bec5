// SPDX-License-Identifier: Apache-2.0
// Columns of a record that a config with an origin has: positions in local north, east, down.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/local_axes.hpp"
#include "score/run.hpp"

namespace binnacle::score {

/// Three for each block whose outputs are latitude, longitude [rad] and height [m]: BLOCK.local_north, local_east and
/// local_down [m] from the origin. None without an origin.
class LocalColumns {
 public:
  LocalColumns() = default;
  LocalColumns(const FilterInfo& filter, const std::optional<geodesy::LocalAxes>& axes);
  const std::vector<RecordColumn>& columns() const { return columns_; }
  /// outputs: of all blocks, in their order. values: as many as columns().
  void read(const double* outputs, double* values) const;

 private:
  geodesy::LocalAxes axes_;
  std::vector<std::size_t> positions_;  // where the three outputs of each such block begin
  std::vector<RecordColumn> columns_;
};

}  // namespace binnacle::score
