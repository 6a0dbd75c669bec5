// SPDX-License-Identifier: Apache-2.0
// Consecutive samples of a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::csv {

struct Block {
  std::vector<Time> times;
  std::vector<std::uint32_t> begins;  // the first row of each sample, with rows; empty: a row is a sample
  std::vector<Time> starts;    // of the intervals of samples put together, no_time where there is none; else empty
  std::vector<int> lines;      // the first of each sample, as far as they are known
  std::vector<double> values;  // row by row, SI
  Time before = no_time;       // the sample before the first; no_time: there is none

  std::size_t size() const { return times.size(); }
  std::size_t row_begin(std::size_t i) const { return begins.empty() ? i : begins[i]; }
  std::size_t row_end(std::size_t i, std::size_t width) const {
    return begins.empty() ? i + 1 : i + 1 < begins.size() ? begins[i + 1] : values.size() / width;
  }
  Time time_before(std::size_t i) const { return i == 0 ? before : times[i - 1]; }

  std::size_t bytes() const {
    return sizeof *this + sizeof(Time) * (times.capacity() + starts.capacity()) +
           sizeof(std::uint32_t) * begins.capacity() + sizeof(int) * lines.capacity() +
           sizeof(double) * values.capacity();
  }

  /// Of all that it holds; another content hardly ever has the same.
  std::uint64_t checksum() const;
};

}  // namespace binnacle::csv
