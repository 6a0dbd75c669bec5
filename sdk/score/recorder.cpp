// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <algorithm>

#include "binnacle/state_block.hpp"
#include "plain_block.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

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

Recorder::Recorder(const Session& session, const Scores& scores, RunObserver& observer, const ScorePlan& plan)
    : session_(session), scores_(scores), observer_(observer) {
  const auto& filters = session.composition().filters();
  for (std::size_t f = 0; f < filters.size(); ++f) {
    auto columns = estimate_columns(filters[f]);
    const auto implied_states = scores[f]->implied_state_columns();
    const auto noise = scores[f]->noise_columns();
    columns.insert(columns.end(), implied_states.begin(), implied_states.end());
    columns.insert(columns.end(), noise.begin(), noise.end());
    Filter& filter = filters_.emplace_back();
    for (const auto& block : filters[f].blocks) filter.is_plain.push_back(is_plain(block));
    filter.implied_state_columns = implied_states.size();
    filter.noise_columns = noise.size();
    filter.local = LocalColumns(filters[f], plan.local);
    columns.insert(columns.end(), filter.local.columns().begin(), filter.local.columns().end());
    filter.epochs = RecordEpochs(plan.record_every);
    filter.kept.resize(columns.size());
    filter.open.resize(columns.size());
    observer.begin(static_cast<int>(f), filters[f].name, columns);
  }
  times_.resize(filters.size());
}

void Recorder::after_instant() {
  using enum RecordEpochs::Choice;
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    const FilterId id{static_cast<int>(f)};
    Filter& filter = filters_[f];
    if (!session_.started(id) || !session_.healthy(id)) continue;
    const Time t = session_.time(id);
    if (t == filter.last) {
      read_again(f);
      continue;
    }
    filter.last = t;
    write_open(f);
    const auto choice = filter.epochs.on(t);
    if (choice == release || choice == release_and_take || choice == release_and_keep) write_kept(f);
    if (choice == take || choice == release_and_take) {
      read(f, t, filter.open);
      filter.open_at = t;
    } else if (choice == keep || choice == release_and_keep) {
      read(f, t, filter.kept);
      filter.kept_at = t;
    }
  }
}

void Recorder::finish() {
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    write_open(f);
    if (filters_[f].epochs.finish()) write_kept(f);
  }
}

/// The filter is where it was: a sample of the same time came in an instant of its own.
void Recorder::read_again(std::size_t filter) {
  Filter& its = filters_[filter];
  if (its.changes == scores_[filter]->changes()) return;
  if (its.open_at == its.last) read(filter, its.last, its.open);
  if (its.kept_at == its.last) read(filter, its.last, its.kept);
}

void Recorder::write_open(std::size_t filter) {
  Filter& its = filters_[filter];
  if (its.open_at != no_time) write(filter, its.open_at, its.open);
  its.open_at = no_time;
}

void Recorder::exchange(StateBytes& bytes) {
  for (Filter& filter : filters_) {
    bytes.value(filter.epochs);
    bytes.value(filter.last);
    bytes.value(filter.kept_at);
    bytes.list(filter.kept);
    bytes.value(filter.open_at);
    bytes.list(filter.open);
    bytes.value(filter.changes);
  }
  for (auto& times : times_) bytes.list(times);
}

void Recorder::write_kept(std::size_t filter) { write(filter, filters_[filter].kept_at, filters_[filter].kept); }

void Recorder::write(std::size_t filter, Time t, std::span<const double> values) {
  observer_.record(static_cast<int>(filter), t, values);
  if (keeps_times_) times_[filter].push_back(t);
}

void Recorder::read(std::size_t filter, Time t, std::span<double> values) {
  const auto& blocks = session_.composition().filters()[filter].blocks;
  const FilterId id{static_cast<int>(filter)};
  std::size_t at = 0;
  const double* const x = session_.state(id).data();
  const ConstMatrixView P = session_.covariance(id);
  const auto for_each_block = [&](const auto& read_plain, const auto& read_block) {
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::size_t count = blocks[b].declaration->outputs.size();
      if (filters_[filter].is_plain[b])
        read_plain(blocks[b], x + blocks[b].stored_offset, values.data() + at);
      else
        read_block(BlockId{id, static_cast<int>(b)}, values.subspan(at, count));
      at += count;
    }
  };
  for_each_block([](const BlockInfo& block, const double* value,
                    double* outputs) { std::copy_n(value, block.declaration->outputs.size(), outputs); },
                 [&](BlockId block, std::span<double> outputs) { session_.read(block, outputs); });
  for_each_block([&](const BlockInfo& block, const double* value,
                     double* sigmas) { plain_sigmas(block, value, P, sigmas); },
                 [&](BlockId block, std::span<double> sigmas) { session_.read_sigma(block, sigmas); });
  FilterScore& score = *scores_[filter];
  filters_[filter].changes = score.changes();
  score.latest_implied_states(t, values.data() + at);
  const Filter& its = filters_[filter];
  at += its.implied_state_columns;
  score.latest_noise(values.data() + at);
  its.local.read(values.data(), values.data() + at + its.noise_columns);
}

}  // namespace binnacle::score
