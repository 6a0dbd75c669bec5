// SPDX-License-Identifier: Apache-2.0
#include "report/watched_run.hpp"

#include <algorithm>

#include "binnacle/state_block.hpp"
#include "binnacle/time.hpp"
#include "score/run.hpp"
#include "thinned_updates.hpp"

namespace binnacle::report {

namespace {

using results::FilterResults;

constexpr std::size_t most_epochs = 2048;

FilterResults without_series(const FilterInfo& info) {
  FilterResults filter;
  filter.name = info.name;
  for (const auto& block : info.blocks)
    for (const auto& output : block.declaration->outputs)
      filter.estimates.push_back({block.name,
                                  output.name,
                                  output.unit,
                                  output.display_unit.empty() ? output.unit : output.display_unit,
                                  output.is_angle,
                                  {},
                                  {}});
  return filter;
}

/// Every other, the first among them.
void halve(std::vector<double>& values) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); i += 2) values[kept++] = values[i];
  values.resize(kept);
}

}  // namespace

class WatchedRun::Filter final : public StepObserver {
 public:
  Filter(const Session& session, int index, const bool& is_watched)
      : session_(session),
        id_{index},
        info_(session.composition().filters()[static_cast<std::size_t>(index)]),
        is_watched_(is_watched),
        estimates_(without_series(info_)) {
    for (const auto& measurement : info_.measurements) updates_.emplace_back(measurement);
    row_.resize(2 * estimates_.estimates.size());
  }

  void pass_on_to(StepObserver* next) { next_ = next; }

  void take() {
    if (!is_readable()) return;
    const Time t = session_.time(id_);
    if (!estimates_.t.empty() && t - newest_ < std::max<Time>(1, every_)) return;
    newest_ = t;
    read();
    append_to(estimates_);
    if (estimates_.t.size() >= most_epochs) thin();
  }

  FilterResults seen() {
    FilterResults filter = estimates_;
    for (const auto& updates : updates_) filter.updates.push_back(updates.updates());
    if (is_readable() && (filter.t.empty() || session_.time(id_) > newest_)) {
      read();
      append_to(filter);
    }
    return filter;
  }

  Wants wants() const override { return next_ ? next_->wants() : Wants::nothing; }
  const double* nominal() override { return next_ ? next_->nominal() : nullptr; }
  void started(Time t, const double* x, ConstMatrixView P) override {
    if (next_) next_->started(t, x, P);
  }
  void rewound(Time t) override {
    if (next_) next_->rewound(t);
    for (auto& updates : updates_) updates.rewind(t == no_time ? -std::numeric_limits<double>::infinity() : seconds(t));
    while (!estimates_.t.empty() && (t == no_time || estimates_.t.back() > seconds(t))) drop_newest();
    if (estimates_.t.empty()) every_ = 0;
    newest_ = std::min(newest_, t);
  }
  void restored(Time t, const double* x, ConstMatrixView P) override {
    if (next_) next_->restored(t, x, P);
  }
  void stepped(const StepRecord& record) override {
    if (next_) next_->stepped(record);
  }
  void offered(const UpdateRecord& record) override {
    if (next_) next_->offered(record);
    if (is_watched_) updates_[static_cast<std::size_t>(record.measurement)].add(record);
  }
  void inflated(const InflationRecord& record) override {
    if (next_) next_->inflated(record);
  }

 private:
  bool is_readable() const { return session_.started(id_) && session_.healthy(id_); }

  void read() {
    const std::span<double> row(row_);
    std::size_t at = 0;
    for (std::size_t b = 0; b < info_.blocks.size(); ++b) {
      const std::size_t count = info_.blocks[b].declaration->outputs.size();
      session_.read({id_, static_cast<int>(b)}, row.subspan(at, count));
      session_.read_sigma({id_, static_cast<int>(b)}, row.subspan(row.size() / 2 + at, count));
      at += count;
    }
  }

  void append_to(FilterResults& filter) const {
    filter.t.push_back(seconds(session_.time(id_)));
    for (std::size_t i = 0; i < filter.estimates.size(); ++i) {
      filter.estimates[i].values.push_back(row_[i]);
      filter.estimates[i].sigma.push_back(row_[row_.size() / 2 + i]);
    }
  }

  void thin() {
    halve(estimates_.t);
    for (auto& estimate : estimates_.estimates) {
      halve(estimate.values);
      halve(estimate.sigma);
    }
    const double span = estimates_.t.back() - estimates_.t.front();
    every_ = std::max(2 * every_, static_cast<Time>(span / static_cast<double>(estimates_.t.size()) * 1e9));
  }

  void drop_newest() {
    estimates_.t.pop_back();
    for (auto& estimate : estimates_.estimates) {
      estimate.values.pop_back();
      estimate.sigma.pop_back();
    }
  }

  const Session& session_;
  FilterId id_;
  const FilterInfo& info_;
  const bool& is_watched_;
  StepObserver* next_ = nullptr;
  FilterResults estimates_;
  std::vector<ThinnedUpdates> updates_;  // by measurement
  std::vector<double> row_;              // outputs, then their 1-σ
  Time newest_ = no_time, every_ = 0;
};

WatchedRun::WatchedRun(const Session& session) : session_(session) {
  for (std::size_t f = 0; f < session.composition().filters().size(); ++f)
    filters_.push_back(std::make_unique<Filter>(session, static_cast<int>(f), is_watched_));
}

WatchedRun::~WatchedRun() = default;

StepObserver* WatchedRun::step_observer(int filter, StepObserver* next) {
  Filter& watched = *filters_[static_cast<std::size_t>(filter)];
  watched.pass_on_to(next);
  return &watched;
}

void WatchedRun::look(bool is_watched) { is_watched_ = is_watched; }

void WatchedRun::take() {
  for (auto& filter : filters_) filter->take();
}

results::RunResults WatchedRun::seen() const {
  results::RunResults run;
  results::Json& figures = run.summary["filters"] = results::Json::object();
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    const FilterId id{static_cast<int>(f)};
    run.filters.push_back(filters_[f]->seen());
    auto& entry = figures[run.filters.back().name] = score::run_figures(session_, id);
    if (!session_.started(id)) entry.erase("verdict");
  }
  return run;
}

}  // namespace binnacle::report
