// SPDX-License-Identifier: Apache-2.0
// RowBlock: rows of a record, as many as a chunk of run.nc has, on their way to the files.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::results {

/// Row by row, as they come.
struct RowBlock {
  std::vector<Time> t;
  std::vector<double> values;  // rows x columns

  std::size_t rows() const { return t.size(); }
  std::size_t bytes() const { return t.size() * sizeof(Time) + values.size() * sizeof(double); }
};

/// The same column by column, for what is kept that way.
class ColumnBlock {
 public:
  /// Of a block whose rows have so many columns.
  void take(const RowBlock& block, std::size_t columns);

  std::size_t rows() const { return t_.size(); }
  std::size_t columns() const { return columns_; }
  /// In seconds, as nearest_seconds() has them.
  std::span<const double> t() const { return t_; }
  std::span<const double> column(std::size_t i) const { return {values_.data() + i * stride_, rows()}; }

 private:
  std::size_t columns_ = 0, stride_ = 0;
  std::vector<double> t_, values_;
};

/// As many rows as make a block of some megabytes, a power of two: the longer a chunk, the less each number costs; a filter of
/// many states must not take all memory for it.
inline std::size_t rows_of_block(std::size_t columns) {
  constexpr std::size_t most = 8192, least = 1024, bytes = 4 << 20;
  return std::clamp(std::bit_floor(bytes / (sizeof(double) * (columns + 1))), least, most);
}

}  // namespace binnacle::results
