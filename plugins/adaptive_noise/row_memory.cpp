// SPDX-License-Identifier: Apache-2.0
// What an estimator remembers of each row, in plain memory, whatever rows a sample has.
#include "row_memory.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace binnacle::adaptive_noise {

namespace {

std::size_t as_size(int n) { return static_cast<std::size_t>(n); }

}  // namespace

RowMemory::RowMemory(const NoiseBinding& binding, int values, std::int64_t lifetime)
    : max_rows_(binding.max_rows), values_(values), lifetime_(lifetime), first_row_(binding.group_first_row) {
  if (first_row_.empty()) first_row_.push_back(0);
}

std::size_t RowMemory::bytes() const noexcept {
  return sizeof(Head) + as_size(max_rows_) * (sizeof(std::int64_t) + sizeof(Slot) + as_size(values_) * sizeof(double));
}

RowMemory::Slot* RowMemory::slot_table(std::byte* memory) const noexcept {
  return reinterpret_cast<Slot*>(memory + sizeof(Head) + as_size(max_rows_) * sizeof(std::int64_t));
}

const RowMemory::Slot* RowMemory::slot_table(const std::byte* memory) const noexcept {
  return reinterpret_cast<const Slot*>(memory + sizeof(Head) + as_size(max_rows_) * sizeof(std::int64_t));
}

double* RowMemory::values(std::byte* memory, int slot) const noexcept {
  return reinterpret_cast<double*>(memory + sizeof(Head) + as_size(max_rows_) * (sizeof(std::int64_t) + sizeof(Slot))) +
         as_size(slot) * as_size(values_);
}

void RowMemory::start(std::byte* memory) const noexcept {
  std::memset(memory, 0, bytes());
  for (int i = 0; i < max_rows_; ++i) slot_table(memory)[i].group = -1;
}

int RowMemory::find(int group, std::int64_t key, int hint, std::byte* memory) const noexcept {
  const Slot* const table = slot_table(memory);
  const auto is_it = [&](int i) { return table[i].group == group && table[i].key == key; };
  if (is_it(hint)) return hint;
  for (int i = 0; i < max_rows_; ++i)
    if (is_it(i)) return i;
  return -1;
}

void RowMemory::enter(const Innovation& innovation, std::byte* memory) const noexcept {
  Head& now = *reinterpret_cast<Head*>(memory);
  now.sample = std::clamp<std::int64_t>(now.sample, 0, std::numeric_limits<std::int64_t>::max() - 1) + 1;
  now.rows = innovation.rows;
  Slot* const table = slot_table(memory);
  std::int64_t* const of_row = slot_of_row(memory);
  for (int i = 0; i < max_rows_; ++i) table[i].last = std::clamp<std::int64_t>(table[i].last, 0, now.sample);
  for (int i = 0; i < max_rows_; ++i)
    if (table[i].group >= 0 && now.sample - table[i].last > lifetime_) table[i].group = -1;
  const auto group_of = [&](int row) {
    return innovation.row_groups.empty()
               ? static_cast<int>(std::upper_bound(first_row_.begin() + 1, first_row_.end(), row) -
                                  first_row_.begin()) -
                     1
               : innovation.row_groups[as_size(row)];
  };
  const auto key_of = [&](int row) { return innovation.row_keys.empty() ? row : innovation.row_keys[as_size(row)]; };
  for (int row = 0; row < innovation.rows; ++row) {
    of_row[row] = find(group_of(row), key_of(row), row, memory);
    if (of_row[row] >= 0) table[of_row[row]].last = now.sample;
  }
  for (int row = 0; row < innovation.rows; ++row) {
    if (of_row[row] >= 0) continue;
    int chosen = 0;  // a free one, else the one not seen for longest; at most max_rows are of this sample
    for (int i = 0; i < max_rows_; ++i) {
      const auto age = [&](int k) { return table[k].group < 0 ? std::int64_t{-1} : table[k].last; };
      if (age(i) < age(chosen)) chosen = i;
    }
    table[chosen] = {group_of(row), key_of(row), now.sample};
    std::fill_n(values(memory, chosen), values_, 0.0);
    of_row[row] = chosen;
  }
}

void Window::clear_place(const RowMemory& rows, std::byte* memory) const noexcept {
  const auto place = rows.sample(memory) % length_;
  for (int i = 0; i < rows.slots(); ++i) rows.values(memory, i)[place] = std::numeric_limits<double>::quiet_NaN();
}

void Window::push(const RowMemory& rows, int slot, double value, std::byte* memory) const noexcept {
  double* const values = rows.values(memory, slot);
  if (values[length_] == 0.0) std::fill_n(values, length_, std::numeric_limits<double>::quiet_NaN());
  values[rows.sample(memory) % length_] = value;
  values[length_] += 1.0;
}

double Window::mean_product(const double* a, const double* b) const noexcept {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < length_; ++i)
    if (!std::isnan(a[i]) && !std::isnan(b[i])) sum += a[i] * b[i], ++count;
  return sum / count;
}

}  // namespace binnacle::adaptive_noise
