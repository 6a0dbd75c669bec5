// SPDX-License-Identifier: Apache-2.0
// Columns: variables that grow along one dimension together, written chunk by chunk.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "netcdf.hpp"

namespace binnacle::results {

/// Values along the growing dimension that are held back until they fill a chunk: 32 kB of doubles.
inline constexpr std::size_t chunk_size = 4096;

/// One variable, or one column of a variable (rows, columns). Columns of one variable are chunks of their own, so that
/// they compress well and may come one after the other.
template <class T>
class Column {
 public:
  Column(nc::Group group, int variable, int column = -1) : group_(group), variable_(variable), column_(column) {}

  void add(T value) { values_.push_back(value); }
  std::size_t size() const { return values_.size(); }
  void pad(std::size_t size, T value) { values_.resize(size, value); }
  void write(std::size_t first) {
    const std::size_t start[] = {first, static_cast<std::size_t>(column_ < 0 ? 0 : column_)};
    const std::size_t count[] = {values_.size(), 1};
    if (!values_.empty()) group_.write(variable_, start, count, values_.data());
    values_.clear();
  }

 private:
  nc::Group group_;
  int variable_;
  int column_;
  std::vector<T> values_;
};

/// Chunks of a variable along a growing dimension, by its rank.
inline std::vector<std::size_t> growing_chunks(std::size_t rank) {
  return rank < 2 ? std::vector<std::size_t>{chunk_size} : std::vector<std::size_t>{chunk_size, 1};
}

}  // namespace binnacle::results
