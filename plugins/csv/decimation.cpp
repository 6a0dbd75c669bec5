// SPDX-License-Identifier: Apache-2.0
#include "decimation.hpp"

#include <algorithm>

namespace binnacle::csv {

void Thinner::take(const Block& from, std::size_t i, Time start, Block& to) {
  if (!layout_.has_intervals) {
    if (index_++ % static_cast<std::uint64_t>(layout_.every) == 0) keep(from, i, to);
    return;
  }
  ++index_;
  if (start == no_time) finish(to);
  join(from, i, start);
  if (start == no_time || count_ == layout_.every) finish(to);
}

void Thinner::keep(const Block& from, std::size_t i, Block& to) const {
  const std::size_t width = layout_.columns.size();
  const auto at = [&](std::size_t row) { return from.values.begin() + static_cast<std::ptrdiff_t>(row * width); };
  if (layout_.rows) to.begins.push_back(static_cast<std::uint32_t>(to.values.size() / width));
  to.times.push_back(from.times[i]);
  to.values.insert(to.values.end(), at(from.row_begin(i)), at(from.row_end(i, width)));
}

void Thinner::join(const Block& from, std::size_t i, Time start) {
  const std::size_t width = layout_.columns.size();
  if (count_++ == 0) {
    start_ = start;
    seconds_in_all_ = 0;
    std::ranges::fill(sums_, 0.0);
  }
  t_ = from.times[i];
  const auto row = from.values.begin() + static_cast<std::ptrdiff_t>(i * width);
  last_.assign(row, row + static_cast<std::ptrdiff_t>(width));
  const double length = start == no_time ? 0 : seconds(t_ - start);
  for (std::size_t c = 0; c < width; ++c)
    sums_[c] += layout_.columns[c].kind == FieldKind::rate ? last_[c] * length : last_[c];
  seconds_in_all_ += length;
}

void Thinner::finish(Block& to) {
  if (count_ == 0) return;
  for (std::size_t c = 0; c < sums_.size(); ++c) {
    const FieldKind kind = layout_.columns[c].kind;
    const bool is_whole = count_ == 1 || kind == FieldKind::level;
    to.values.push_back(is_whole ? last_[c] : kind == FieldKind::rate ? sums_[c] / seconds_in_all_ : sums_[c]);
  }
  to.starts.push_back(start_);
  to.times.push_back(t_);
  count_ = 0;
}

}  // namespace binnacle::csv
