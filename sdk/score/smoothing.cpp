// SPDX-License-Identifier: Apache-2.0
#include "smoothing.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

#include "binnacle/eigen.hpp"
#include "binnacle/state_block.hpp"
#include "recorder.hpp"
#include "wording/block_call.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

EpochFile::EpochFile(const FilterInfo& filter)
    : file_(std::tmpfile()), dof_(filter.dof), stored_size_(as_size(filter.stored_size)) {
  if (!file_) throw std::runtime_error("there is no room for a temporary file, which smoothing needs");
  record_.resize(1 + stored_size_ + as_size(dof_ * (dof_ + 1) / 2));
  P_.resize(as_size(dof_) * as_size(dof_));
}

void EpochFile::write(const smooth::Epoch& epoch) {
  double* to = record_.data();
  *to++ = std::bit_cast<double>(epoch.t);
  to = std::copy_n(epoch.x, stored_size_, to);
  for (int j = 0; j < dof_; ++j)
    for (int i = j; i < dof_; ++i) *to++ = epoch.P(i, j);
  if (std::fwrite(record_.data(), sizeof(double), record_.size(), file_.get()) != record_.size())
    throw std::runtime_error("the temporary file of a smoother cannot be written: is the disk full?");
  ++count_;
}

void EpochFile::clear() {
  std::rewind(file_.get());
  count_ = 0;
}

smooth::Epoch EpochFile::read(std::int64_t index) {
  const auto size = static_cast<std::int64_t>(record_.size() * sizeof(double));
  if (fseeko(file_.get(), index * size, SEEK_SET) != 0 ||
      std::fread(record_.data(), sizeof(double), record_.size(), file_.get()) != record_.size())
    throw std::runtime_error("the temporary file of a smoother cannot be read");
  const double* from = record_.data();
  smooth::Epoch epoch;
  epoch.t = std::bit_cast<Time>(*from++);
  epoch.x = from;
  from += stored_size_;
  const MatrixView P{P_.data(), dof_, dof_, dof_};
  for (int j = 0; j < dof_; ++j)
    for (int i = j; i < dof_; ++i) P(i, j) = P(j, i) = *from++;
  epoch.P = P;
  return epoch;
}

Smoothing::Filter::Filter(const ScorePlan& all, const SmoothingPlan& smoothing, Session& session)
    : plan(smoothing),
      info(all.filters[as_size(smoothing.as)]),
      local(info, all.local),
      score(std::make_unique<FilterScore>(all, smoothing)),
      epochs(info) {
  if (!smoothing.lag) {
    backward = std::make_unique<smooth::SmoothedFilter>(session, smoothing.of, smoothing.iterations);
    return;
  }
  // Both ends of a step in which a reference lies, and what is recorded.
  const auto keep = [this](const smooth::Epoch& epoch) {
    const auto next = std::ranges::lower_bound(wanted, last.t);
    const bool is_wanted = next != wanted.end() && *next < epoch.t;
    if (is_wanted && !is_written) epochs.write({last.t, last_x.data(), {last_P.data(), info.dof, info.dof, info.dof}});
    is_written = is_wanted || std::ranges::binary_search(recorded, epoch.t);
    if (is_written) epochs.write(epoch);
    last.t = epoch.t;
    std::copy_n(epoch.x, last_x.size(), last_x.begin());
    MatrixView{last_P.data(), info.dof, info.dof, info.dof}.as() = epoch.P.as();
  };
  last_x.resize(as_size(info.stored_size));
  last_P.resize(as_size(info.dof) * as_size(info.dof));
  is_written = true;  // there is no epoch before the first
  lag = std::make_unique<smooth::FixedLag>(session, FilterId{smoothing.of}, *smoothing.lag, keep,
                                           [this](smooth::WithheldSample sample) {
                                             withheld.push_back(std::move(sample));
                                           });
}

Smoothing::Smoothing(const ScorePlan& plan, Session& session, RunObserver& observer, bool records)
    : session_(session), observer_(observer), records_(records), smoother_(session) {
  for (const SmoothingPlan& smoothing : plan.smoothings) {
    Filter& filter = *filters_.emplace_back(std::make_unique<Filter>(plan, smoothing, session));
    if (!records) continue;
    filter.score->keep_sigmas();
    auto columns = estimate_columns(filter.info);
    columns.insert(columns.end(), filter.local.columns().begin(), filter.local.columns().end());
    row_.resize(std::max(row_.size(), columns.size()));
    for (const BlockInfo& block : filter.info.blocks)
      sigma_scratch_.resize(std::max(sigma_scratch_.size(), output_sigma_scratch(block)));
    observer.begin(smoothing.as, filter.info.name, columns);
  }
}

void Smoothing::exchange(StateBytes& bytes) {
  smoother_.exchange(bytes);
  for (auto& filter : filters_) {
    bytes.list(filter->references, [&](Reference& reference) {
      bytes.value(reference.channel);
      bytes.value(reference.t);
      bytes.value(reference.t0);
      bytes.list(reference.fields);
    });
    bytes.list(filter->wanted);
  }
}

void Smoothing::sampled(int channel, const SampleView& sample, const std::function<bool(int filter)>& is_of) {
  const int count = session_.composition().channels()[as_size(channel)].declaration->count(false);
  for (auto& filter : filters_) {
    if (!is_of(filter->plan.of) || !filter->score->refers_to(channel)) continue;
    filter->references.push_back({channel, sample.t, sample.t0, {sample.fields, sample.fields + count}});
    filter->wanted.push_back(sample.t);
  }
}

/// What is recorded, and the very last estimate.
void Smoothing::mark(Filter& filter) {
  const FilterId id{filter.plan.of};
  if (!session_.started(id)) return;
  const Time t = session_.time(id);
  if (t == filter.marked || !std::ranges::binary_search(filter.recorded, t)) return;
  filter.marked = t;
  filter.backward->mark();
}

void Smoothing::finish(const std::vector<std::vector<Time>>& recorded) {
  for (auto& filter : filters_) {
    std::ranges::sort(filter->wanted);
    filter->recorded = recorded[as_size(filter->plan.of)];
  }
  is_running_again_ = true;
  smooth_with_lag();
  smooth_intervals();
  is_running_again_ = false;
  for (auto& filter : filters_) replay(*filter);
}

void Smoothing::smooth_with_lag() {
  std::vector<std::pair<FilterId, StepObserver*>> observers;
  for (auto& filter : filters_)
    if (filter->lag) observers.emplace_back(FilterId{filter->plan.of}, filter->lag.get());
  if (observers.empty()) return;
  smoother_.run_again(observers);
  for (auto& filter : filters_)
    if (filter->lag) filter->lag->finish();
}

void Smoothing::smooth_intervals() {
  smooth::IntervalSmoother::Backward backward;
  for (auto& filter : filters_) {
    if (!filter->backward) continue;
    filter->backward->stretch().want(filter->wanted);
    backward.filters.push_back(filter->backward.get());
  }
  if (backward.filters.empty()) return;
  const auto of = [&](smooth::SmoothedFilter& swept) -> Filter& {
    return **std::ranges::find_if(filters_, [&](const auto& filter) { return filter->backward.get() == &swept; });
  };
  backward.each = [&](smooth::SmoothedFilter& filter) { mark(of(filter)); };
  backward.sweep = [&](smooth::SmoothedFilter& swept) {
    Filter& filter = of(swept);
    swept.sweep([&](const smooth::Epoch& epoch) { filter.epochs.write(epoch); },
                [&](smooth::WithheldSample sample) { filter.withheld.push_back(std::move(sample)); });
    filter.marked = no_time;
  };
  backward.again = [&](smooth::SmoothedFilter& filter) {
    of(filter).epochs.clear();
    of(filter).withheld.clear();
  };
  smoother_.run_back(backward);
}

/// Shows the smoothed estimates in order of time, with the references and withheld samples between them.
void Smoothing::replay(Filter& filter) {
  FilterScore& score = *filter.score;
  score.set_start(session_.start_time({filter.plan.of}));
  auto reference = filter.references.begin();
  auto recorded = filter.recorded.begin();
  std::vector<double> x(as_size(filter.info.stored_size)), P(as_size(filter.info.dof) * as_size(filter.info.dof));
  const MatrixView P0{P.data(), filter.info.dof, filter.info.dof, filter.info.dof};
  Time t0 = no_time;
  const std::int64_t count = filter.epochs.count();
  for (std::int64_t i = 0; i < count; ++i) {
    const smooth::Epoch epoch = filter.epochs.read(filter.lag ? i : count - 1 - i);
    for (; reference != filter.references.end() && reference->t < epoch.t; ++reference) {
      SampleView sample;
      sample.t = reference->t;
      sample.t0 = reference->t0;
      sample.fields = reference->fields.data();
      score.reference(reference->channel, sample);
    }
    StepRecord step;
    step.t0 = t0;
    step.t1 = epoch.t;
    step.x0 = x.data();
    step.x1 = epoch.x;
    step.P0 = P0;
    if (t0 != no_time && epoch.t > t0) score.stepped(step);
    for (; recorded != filter.recorded.end() && *recorded <= epoch.t; ++recorded)
      if (*recorded == epoch.t) record(filter, epoch);
    t0 = epoch.t;
    std::copy_n(epoch.x, x.size(), x.begin());
    P0.as() = epoch.P.as();
  }
  std::ranges::stable_sort(filter.withheld, {}, &smooth::WithheldSample::t);
  for (const smooth::WithheldSample& sample : filter.withheld) {
    UpdateRecord update;
    update.measurement = sample.measurement;
    update.t = sample.t;
    update.outcome = Outcome::withheld;
    update.rows = static_cast<int>(sample.residual.size());
    update.row_groups = sample.groups.data();
    update.residual = sample.residual.data();
    score.withheld(update);
  }
  score.finish();
  if (records_) score.show_errors(observer_);
}

void Smoothing::record(const Filter& filter, const smooth::Epoch& epoch) {
  if (!records_) return;
  std::size_t outputs = 0;
  for (const BlockInfo& block : filter.info.blocks) outputs += block.declaration->outputs.size();
  double* value = row_.data();
  double* sigma = value + outputs;
  for (const BlockInfo& block : filter.info.blocks) {
    const std::size_t count = block.declaration->outputs.size();
    const double* const x = epoch.x + block.stored_offset;
    call_block(block, "read", epoch.t, [&] {
      block.block->read({x, block.declaration->stored_size}, {value, static_cast<int>(count)});
      output_sigmas(block, x, epoch.P, sigma_scratch_.data(), sigma);
    });
    value += count;
    sigma += count;
  }
  filter.local.read(row_.data(), row_.data() + 2 * outputs);
  observer_.record(filter.plan.as, epoch.t, {row_.data(), 2 * outputs + filter.local.columns().size()});
}

nlohmann::ordered_json Smoothing::summary(std::size_t index) const {
  const Filter& filter = *filters_[index];
  auto figures = filter.score->summary();
  const std::string& of = session_.composition().filters()[as_size(filter.plan.of)].name;
  if (filter.lag) {
    figures["smoother"] = {{"type", "fixed_lag"},
                           {"of", of},
                           {"lag_s", seconds(filter.plan.lag->lag)},
                           {"every_s", seconds(filter.plan.lag->every)},
                           {"breaks", filter.lag->has_breaks() ? 1 : 0}};
    return figures;
  }
  figures["smoother"] = {{"type", "fixed_interval"}, {"of", of}, {"breaks", filter.backward->breaks()}};
  const smooth::Iterations& iterations = filter.backward->iterations();
  if (iterations.wanted == 0) return figures;
  figures["smoother"]["iterations"] = iterations.done;
  figures["smoother"]["converged"] = iterations.converged;
  if (iterations.done > 0) figures["smoother"]["change"] = iterations.change;
  if (!iterations.reason.empty()) figures["smoother"]["reason"] = iterations.reason;
  return figures;
}

}  // namespace binnacle::score
