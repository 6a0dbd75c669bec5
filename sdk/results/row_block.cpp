// SPDX-License-Identifier: Apache-2.0
#include "results/row_block.hpp"

#include "results/seconds.hpp"

namespace binnacle::results {

void ColumnBlock::take(const RowBlock& block, std::size_t columns) {
  columns_ = columns;
  t_.resize(block.rows());
  std::transform(block.t.begin(), block.t.end(), t_.begin(), nearest_seconds);
  // In tiles, so that a row's cache lines are used while they are there; a line between columns, since those of a round length
  // would all want the same places of the cache.
  constexpr std::size_t tile = 16, line = 8;
  const std::size_t rows = block.rows();
  stride_ = rows + line;
  values_.resize(stride_ * columns);
  for (std::size_t first = 0; first < rows; first += tile)
    for (std::size_t c = 0; c < columns; ++c)
      for (std::size_t r = first; r < std::min(first + tile, rows); ++r)
        values_[c * stride_ + r] = block.values[r * columns + c];
}

}  // namespace binnacle::results
