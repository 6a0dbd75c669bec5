// SPDX-License-Identifier: Apache-2.0
// What an estimator remembers of each row, in plain memory, whatever rows a sample has.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "binnacle/noise_estimator.hpp"

namespace binnacle::adaptive_noise {

/// A slot per row, found again by the row's group and key: a satellite that moves from row 2 to row 5 keeps its past. There
/// are as many slots as a sample may have rows; one whose row has not been seen for `lifetime` samples is forgotten, and
/// when all are taken the one not seen for longest makes room.
class RowMemory {
 public:
  /// values: doubles that the estimator keeps per slot. The memory is declared in `declaration`.
  RowMemory(MemoryDeclaration& declaration, const NoiseBinding& binding, int values,
            std::int64_t lifetime = std::numeric_limits<std::int64_t>::max());

  /// A sample begins: every row has its slot. A new slot's values are zero.
  void enter(const Innovation& in) const noexcept;

  int max_rows() const noexcept { return max_rows_; }
  int groups() const noexcept { return groups_; }

  // Of the sample entered last. What was restored from a damaged snapshot must not lead outside of the memory.
  std::int64_t sample(const MemoryView& memory) const noexcept {
    return std::max<std::int64_t>(memory[head_].sample, 0);
  }
  int rows(const MemoryView& memory) const noexcept {
    return static_cast<int>(std::clamp<std::int64_t>(memory[head_].rows, 0, max_rows_));
  }
  int slot(const MemoryView& memory, int row) const noexcept {
    const std::int64_t stored = memory[slot_of_row_][static_cast<std::size_t>(row)];
    return static_cast<int>(std::clamp<std::int64_t>(stored, 0, max_rows_ - 1));
  }
  int group(const MemoryView& memory, int row) const noexcept {
    const std::int64_t stored = memory[slots_][static_cast<std::size_t>(slot(memory, row))].group;
    return static_cast<int>(std::clamp<std::int64_t>(stored, 0, groups() - 1));
  }
  std::span<double> values(const MemoryView& memory, int slot) const noexcept {
    const auto size = static_cast<std::size_t>(values_per_slot_);
    return memory[values_].subspan(static_cast<std::size_t>(slot) * size, size);
  }
  int slots() const noexcept { return max_rows_; }

 private:
  struct Head {
    std::int64_t sample = 0, rows = 0;
  };
  struct Slot {
    std::int64_t group = -1, key = 0, last = 0;  // group −1: free
  };
  int find(int group, std::int64_t key, int hint, const MemoryView& memory) const noexcept;

  int max_rows_;
  int values_per_slot_;
  std::int64_t lifetime_;
  int groups_;
  Memory<Head> head_;
  MemoryArray<std::int64_t> slot_of_row_;
  MemoryArray<Slot> slots_;
  MemoryArray<double> values_;
};

/// The last `length` samples of a number per row, NaN where the row was missing: values [0, length) of a slot. The next
/// value is its count.
class Window {
 public:
  static int values(int length) { return length + 1; }

  explicit Window(int length) : length_(length) {}
  int length() const noexcept { return length_; }
  /// A sample begins for all slots: its place is empty.
  void clear_place(const RowMemory& rows, const MemoryView& memory) const noexcept;
  void push(const RowMemory& rows, int slot, double value, const MemoryView& memory) const noexcept;
  /// Mean of the products of two rows over the samples that had both; NaN if there are none.
  double mean_product(std::span<const double> a, std::span<const double> b) const noexcept;
  /// Whether `length` values were pushed.
  bool is_full(std::span<const double> values) const noexcept { return values.back() >= length_; }

 private:
  int length_;
};

}  // namespace binnacle::adaptive_noise
