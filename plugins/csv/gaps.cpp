// SPDX-License-Identifier: Apache-2.0
// Steps between the times of samples: the usual one, and those that are too long.
#include "gaps.hpp"

#include <algorithm>
#include <bit>

#include "cells.hpp"
#include "row_reader.hpp"

namespace binnacle::csv {

namespace {

/// A class has the lengths of one power of two that have the same ten bits behind the highest.
constexpr int class_bits = 10;

std::size_t class_of(Time length) {
  const auto value = static_cast<std::uint64_t>(length);
  const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - 1 - class_bits);
  return (static_cast<std::size_t>(shift) << class_bits) + static_cast<std::size_t>(value >> shift);
}

constexpr std::size_t class_count = std::size_t{66} << class_bits;

/// The first index up to which more than `rank` are counted; `rank` is then that within it.
std::size_t index_of(const std::vector<std::uint64_t>& counts, std::uint64_t& rank) {
  std::size_t i = 0;
  for (; i + 1 < counts.size() && rank >= counts[i]; ++i) rank -= counts[i];
  return i;
}

}  // namespace

void Gaps::add(const Step& first, std::size_t count) {
  if (first.length <= max_) return;
  if (count_ == 0 || first.from < first_.from) first_ = first;
  if (first.length > longest_.length) longest_ = first;
  count_ += count;
  total_ += first.length * static_cast<Time>(count);  // all of them fit between the first label and the last
}

std::string Gaps::message() const {
  const auto span = [](const Step& step) { return time_text(step.from) + " to " + time_text(step.from + step.length); };
  const std::string message = count_of(count_, "gap") + " longer than " + time_text(max_);
  if (count_ == 1) return message + ": " + time_text(longest_.length) + " from " + span(first_);
  return message + ", " + time_text(total_) + " in all; the first from " + span(first_) + "; the longest, " +
         time_text(longest_.length) + ", ends at line " + std::to_string(longest_.line);
}

void StepCounts::add(const Step& step) {
  ++count_;
  if (!classes_.empty()) {
    ++classes_[class_of(step.length)];
    return;
  }
  if (!last_ || last_->first.length != step.length) {
    last_ = &lengths_[step.length];
    if (last_->count == 0) last_->first = step;
  }
  ++last_->count;
  if (lengths_.size() > most_) classify();
}

void StepCounts::classify() {
  classes_.resize(class_count);
  for (const auto& [length, each] : lengths_) classes_[class_of(length)] += each.count;
  lengths_.clear();
  last_ = nullptr;
}

Time StepCounts::median(const StepPass& pass) const {
  Range range;
  range.rank = count_ / 2;
  if (classes_.empty()) {
    std::vector<Time> lengths;
    for (const auto& each : lengths_) lengths.push_back(each.first);
    std::ranges::sort(lengths);
    for (const Time length : lengths) {
      const std::uint64_t count = lengths_.at(length).count;
      if (range.rank < count) return length;
      range.rank -= count;
    }
    return lengths.back();
  }
  for (range = find_class(); range.width > 1;) {
    const std::uint64_t bin = (range.width - 1) / std::max<std::size_t>(most_, 2) + 1;
    std::vector<std::uint64_t> counts((range.width - 1) / bin + 1);
    pass([&](const Step& step) {
      const std::uint64_t above = static_cast<std::uint64_t>(step.length) - range.low;
      if (above < range.width) ++counts[above / bin];
    });
    range.low += bin * index_of(counts, range.rank);
    range.width = bin;
  }
  return static_cast<Time>(range.low);
}

StepCounts::Range StepCounts::find_class() const {
  Range range;
  range.rank = count_ / 2;
  const std::size_t found = index_of(classes_, range.rank);
  const std::size_t shift = std::max<std::size_t>(found >> class_bits, 1) - 1;
  range.low = static_cast<std::uint64_t>(found - (shift << class_bits)) << shift;
  range.width = std::uint64_t{1} << shift;
  return range;
}

bool StepCounts::collect(Gaps& gaps) const {
  if (!classes_.empty()) return false;
  for (const auto& [length, each] : lengths_) gaps.add(each.first, each.count);
  return true;
}

}  // namespace binnacle::csv
