// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <algorithm>

#include "binnacle/state_block.hpp"
#include "text.hpp"

namespace binnacle::score {

namespace {

/// Outputs of all blocks, then their 1-σ.
std::vector<RecordColumn> estimate_columns(const FilterInfo& filter) {
  std::vector<RecordColumn> columns, sigmas;
  for (const auto& block : filter.blocks)
    for (const auto& output : block.declaration->outputs) {
      columns.push_back({block.name + "." + output.name, output.unit});
      sigmas.push_back({block.name + "." + output.name + ".sigma", output.unit});
    }
  columns.insert(columns.end(), sigmas.begin(), sigmas.end());
  return columns;
}

}  // namespace

Recorder::Recorder(const Session& session, const Scores& scores, RunObserver& observer, Time every)
    : session_(session), scores_(scores), observer_(observer), every_(every) {
  const auto& filters = session.composition().filters();
  std::size_t width = 1;
  for (std::size_t f = 0; f < filters.size(); ++f) {
    auto columns = estimate_columns(filters[f]);
    const auto implied_states = scores[f]->implied_state_columns();
    const auto noise = scores[f]->noise_columns();
    columns.insert(columns.end(), implied_states.begin(), implied_states.end());
    columns.insert(columns.end(), noise.begin(), noise.end());
    filters_.push_back({implied_states.size(), noise.size()});
    width = std::max(width, columns.size());
    observer.begin(static_cast<int>(f), filters[f].name, columns);
  }
  values_.resize(width);
}

void Recorder::after_instant() {
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    const int index = static_cast<int>(f);
    Filter& filter = filters_[f];
    if (!session_.started(index) || !session_.healthy(index)) continue;
    const Time t = session_.time(index);
    if (t == filter.last || (filter.next != no_time && t < filter.next)) continue;
    filter.last = t;
    if (every_ > 0)
      filter.next = filter.next == no_time ? t + every_ : filter.next + (1 + (t - filter.next) / every_) * every_;
    record(index, t);
  }
}

void Recorder::record(int filter, Time t) {
  const auto& blocks = session_.composition().filters()[as_size(filter)].blocks;
  std::size_t at = 0;
  const auto for_each_block = [&](const auto& read) {
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::size_t count = blocks[b].declaration->outputs.size();
      read(Session::Block{filter, static_cast<int>(b)}, std::span<double>(values_.data() + at, count));
      at += count;
    }
  };
  for_each_block([&](Session::Block block, std::span<double> values) { session_.read(block, values); });
  for_each_block([&](Session::Block block, std::span<double> values) { session_.read_sigma(block, values); });
  FilterScore& score = *scores_[as_size(filter)];
  score.latest_implied_states(t, values_.data() + at);
  at += filters_[as_size(filter)].implied_state_columns;
  score.latest_noise(values_.data() + at);
  at += filters_[as_size(filter)].noise_columns;
  observer_.record(filter, t, {values_.data(), at});
}

}  // namespace binnacle::score
