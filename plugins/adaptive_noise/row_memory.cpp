// SPDX-License-Identifier: Apache-2.0
// What an estimator remembers of each row, in plain memory, whatever rows a sample has.
#include "row_memory.hpp"

#include <cmath>

namespace binnacle::adaptive_noise {

namespace {

std::size_t as_size(int n) { return static_cast<std::size_t>(n); }

}  // namespace

RowMemory::RowMemory(MemoryDeclaration& declaration, const NoiseBinding& binding, int values, std::int64_t lifetime)
    : max_rows_(binding.max_rows),
      values_per_slot_(values),
      lifetime_(lifetime),
      groups_(std::max(1, static_cast<int>(binding.groups.size()))),
      head_(declaration.keeps<Head>()),
      slot_of_row_(declaration.keeps_array<std::int64_t>(as_size(max_rows_))),
      slots_(declaration.keeps_array<Slot>(as_size(max_rows_))),
      values_(declaration.keeps_array<double>(as_size(max_rows_) * as_size(values))) {}

int RowMemory::find(int group, std::int64_t key, int hint, const MemoryView& memory) const noexcept {
  const auto table = memory[slots_];
  const auto is_it = [&](int i) { return table[as_size(i)].group == group && table[as_size(i)].key == key; };
  if (is_it(hint)) return hint;
  for (int i = 0; i < max_rows_; ++i)
    if (is_it(i)) return i;
  return -1;
}

void RowMemory::enter(const Innovation& in) const noexcept {
  const MemoryView& memory = in.memory;
  Head& now = memory[head_];
  now.sample = std::clamp<std::int64_t>(now.sample, 0, std::numeric_limits<std::int64_t>::max() - 1) + 1;
  now.rows = in.rows;
  const auto table = memory[slots_];
  const auto of_row = memory[slot_of_row_];
  for (Slot& slot : table) {
    slot.last = std::clamp<std::int64_t>(slot.last, 0, now.sample);
    if (slot.group >= 0 && now.sample - slot.last > lifetime_) slot.group = -1;
  }
  const auto group_of = [&](int row) { return in.row_groups[as_size(row)]; };
  const auto key_of = [&](int row) { return in.row_keys[as_size(row)]; };
  for (int row = 0; row < in.rows; ++row) {
    const int found = find(group_of(row), key_of(row), row, memory);
    of_row[as_size(row)] = found;
    if (found >= 0) table[as_size(found)].last = now.sample;
  }
  for (int row = 0; row < in.rows; ++row) {
    if (of_row[as_size(row)] >= 0) continue;
    // A free one, else the one not seen for longest; at most max_rows are of this sample.
    const auto age = [](const Slot& slot) { return slot.group < 0 ? std::int64_t{-1} : slot.last; };
    const auto chosen =
        std::min_element(table.begin(), table.end(), [&](const Slot& a, const Slot& b) { return age(a) < age(b); });
    *chosen = {group_of(row), key_of(row), now.sample};
    const int slot = static_cast<int>(chosen - table.begin());
    std::ranges::fill(values(memory, slot), 0.0);
    of_row[as_size(row)] = slot;
  }
}

void Window::clear_place(const RowMemory& rows, const MemoryView& memory) const noexcept {
  const auto place = static_cast<std::size_t>(rows.sample(memory) % length_);
  for (int i = 0; i < rows.slots(); ++i) rows.values(memory, i)[place] = std::numeric_limits<double>::quiet_NaN();
}

void Window::push(const RowMemory& rows, int slot, double value, const MemoryView& memory) const noexcept {
  const std::span<double> values = rows.values(memory, slot);
  if (values.back() == 0.0) std::fill_n(values.begin(), length_, std::numeric_limits<double>::quiet_NaN());
  values[static_cast<std::size_t>(rows.sample(memory) % length_)] = value;
  values.back() += 1.0;
}

double Window::mean_product(std::span<const double> a, std::span<const double> b) const noexcept {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < as_size(length_); ++i)
    if (!std::isnan(a[i]) && !std::isnan(b[i])) sum += a[i] * b[i], ++count;
  return sum / count;
}

}  // namespace binnacle::adaptive_noise
