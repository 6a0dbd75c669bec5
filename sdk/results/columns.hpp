// SPDX-License-Identifier: Apache-2.0
// Variables that grow along one dimension together, written chunk by chunk.
#pragma once

#include <cstddef>
#include <span>

#include "netcdf.hpp"

namespace binnacle::results {

/// Samples along the growing dimension that are held back until they fill a chunk: 32 kB of doubles.
inline constexpr std::size_t chunk_size = 4096;

/// One variable, or one column of a variable (rows, columns).
struct Column {
  int variable = -1;
  int column = -1;  // -1: it has none
};

template <class T>
void write_rows(nc::Group group, Column to, std::size_t first, std::span<const T> values) {
  const std::size_t start[] = {first, static_cast<std::size_t>(to.column < 0 ? 0 : to.column)};
  const std::size_t count[] = {values.size(), 1};
  if (!values.empty()) group.write(to.variable, start, count, values.data());
}

/// Of a variable along a growing dimension, by its rank, `rows` in a chunk. Columns of one variable are chunks of their own, so
/// that they compress well and may come one after the other.
inline nc::Storage growing(std::size_t rank, std::size_t rows, int level) {
  nc::Storage storage{{rows}, level};
  if (rank > 1) storage.chunks.push_back(1);
  return storage;
}

}  // namespace binnacle::results
