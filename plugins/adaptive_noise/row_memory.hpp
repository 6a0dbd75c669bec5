// SPDX-License-Identifier: Apache-2.0
// What an estimator remembers of each row, in plain memory, whatever rows a sample has.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "binnacle/noise_estimator.hpp"

namespace binnacle::adaptive_noise {

/// A slot per row, found again by the row's group and key: a satellite that moves from row 2 to row 5 keeps its past. There
/// are as many slots as a sample may have rows; one whose row has not been seen for `lifetime` samples is forgotten, and
/// when all are taken the one not seen for longest makes room.
class RowMemory {
 public:
  /// values: doubles that the estimator keeps per slot.
  RowMemory(const NoiseBinding& binding, int values, std::int64_t lifetime = std::numeric_limits<std::int64_t>::max());

  std::size_t bytes() const noexcept;
  void start(std::byte* memory) const noexcept;
  /// A sample begins: every row has its slot. A new slot's values are zero.
  void enter(const Innovation& innovation, std::byte* memory) const noexcept;

  int max_rows() const noexcept { return max_rows_; }
  int groups() const noexcept { return static_cast<int>(first_row_.size()); }

  // Of the sample entered last. What was restored from a damaged snapshot must not lead outside of the memory.
  std::int64_t sample(const std::byte* memory) const noexcept { return std::max<std::int64_t>(head(memory).sample, 0); }
  int rows(const std::byte* memory) const noexcept {
    return static_cast<int>(std::clamp<std::int64_t>(head(memory).rows, 0, max_rows_));
  }
  int slot(const std::byte* memory, int row) const noexcept {
    const std::int64_t stored = reinterpret_cast<const std::int64_t*>(memory + sizeof(Head))[row];
    return static_cast<int>(std::clamp<std::int64_t>(stored, 0, max_rows_ - 1));
  }
  int group(const std::byte* memory, int row) const noexcept {
    return static_cast<int>(std::clamp<std::int64_t>(slot_table(memory)[slot(memory, row)].group, 0, groups() - 1));
  }
  double* values(std::byte* memory, int slot) const noexcept;
  int slots() const noexcept { return max_rows_; }

 private:
  struct Head {
    std::int64_t sample, rows;
  };
  struct Slot {
    std::int64_t group, key, last;  // group −1: free
  };
  static const Head& head(const std::byte* memory) noexcept { return *reinterpret_cast<const Head*>(memory); }
  static std::int64_t* slot_of_row(std::byte* memory) noexcept {
    return reinterpret_cast<std::int64_t*>(memory + sizeof(Head));
  }
  Slot* slot_table(std::byte* memory) const noexcept;
  const Slot* slot_table(const std::byte* memory) const noexcept;
  int find(int group, std::int64_t key, int hint, std::byte* memory) const noexcept;

  int max_rows_;
  int values_;
  std::int64_t lifetime_;
  std::vector<int> first_row_;
};

/// The last `length` samples of a number per row, NaN where the row was missing: values [0, length) of a slot. The next
/// value is its count.
class Window {
 public:
  static int values(int length) { return length + 1; }

  explicit Window(int length) : length_(length) {}
  int length() const noexcept { return length_; }
  /// A sample begins for all slots: its place is empty.
  void clear_place(const RowMemory& rows, std::byte* memory) const noexcept;
  void push(const RowMemory& rows, int slot, double value, std::byte* memory) const noexcept;
  /// Mean of the products of two rows over the samples that had both; NaN if there are none.
  double mean_product(const double* a, const double* b) const noexcept;
  /// Whether `length` values were pushed.
  bool is_full(const double* values) const noexcept { return values[length_] >= length_; }

 private:
  int length_;
};

}  // namespace binnacle::adaptive_noise
