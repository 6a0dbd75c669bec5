// SPDX-License-Identifier: Apache-2.0
#include "smoothing.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

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

bool EpochFile::read_back(smooth::Epoch& epoch) {
  if (count_ == 0) return false;
  const auto size = static_cast<std::int64_t>(record_.size() * sizeof(double));
  if (fseeko(file_.get(), --count_ * size, SEEK_SET) != 0 ||
      std::fread(record_.data(), sizeof(double), record_.size(), file_.get()) != record_.size())
    throw std::runtime_error("the temporary file of a smoother cannot be read");
  const double* from = record_.data();
  epoch.t = std::bit_cast<Time>(*from++);
  epoch.x = from;
  from += stored_size_;
  const MatrixView P{P_.data(), dof_, dof_, dof_};
  for (int j = 0; j < dof_; ++j)
    for (int i = j; i < dof_; ++i) P(i, j) = P(j, i) = *from++;
  epoch.P = P;
  return true;
}

Smoothing::Filter::Filter(const ScorePlan& all, const SmoothingPlan& smoothing, Session& session)
    : plan(smoothing),
      info(all.filters[as_size(smoothing.as)]),
      backward(session, smoothing.of, smoothing.iterations),
      score(std::make_unique<FilterScore>(all, smoothing)),
      epochs(info) {}

Smoothing::Smoothing(const ScorePlan& plan, Session& session, RunObserver& observer, bool records)
    : session_(session), observer_(observer), records_(records), smoother_(session) {
  for (const SmoothingPlan& smoothing : plan.smoothings) {
    Filter& filter = *filters_.emplace_back(std::make_unique<Filter>(plan, smoothing, session));
    if (!records) continue;
    filter.score->keep_sigmas();
    const auto columns = estimate_columns(filter.info);
    row_.resize(std::max(row_.size(), columns.size()));
    for (const BlockInfo& block : filter.info.blocks)
      sigma_scratch_.resize(std::max(sigma_scratch_.size(), output_sigma_scratch(block)));
    observer.begin(smoothing.as, filter.info.name, columns);
  }
}

void Smoothing::sampled(int channel, const SampleView& sample) {
  const int count = session_.composition().channels()[as_size(channel)].declaration->count(false);
  for (auto& filter : filters_) {
    if (!filter->score->refers_to(channel)) continue;
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
  filter.backward.mark();
}

void Smoothing::finish(const std::vector<std::vector<Time>>& recorded) {
  smooth::IntervalSmoother::Backward backward;
  for (auto& filter : filters_) {
    std::ranges::sort(filter->wanted);
    filter->backward.stretch().want(filter->wanted);
    filter->recorded = recorded[as_size(filter->plan.of)];
    backward.filters.push_back(&filter->backward);
  }
  const auto of = [&](smooth::SmoothedFilter& swept) -> Filter& {
    return **std::ranges::find_if(filters_, [&](const auto& filter) { return &filter->backward == &swept; });
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
  is_running_again_ = true;
  smoother_.run_back(backward);
  is_running_again_ = false;
  for (auto& filter : filters_) replay(*filter);
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
  for (smooth::Epoch epoch; filter.epochs.read_back(epoch);) {
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
  for (auto sample = filter.withheld.rbegin(); sample != filter.withheld.rend(); ++sample) {
    UpdateRecord update;
    update.measurement = sample->measurement;
    update.t = sample->t;
    update.outcome = Outcome::withheld;
    update.rows = static_cast<int>(sample->residual.size());
    update.row_groups = sample->groups.data();
    update.residual = sample->residual.data();
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
  observer_.record(filter.plan.as, epoch.t, {row_.data(), 2 * outputs});
}

nlohmann::ordered_json Smoothing::summary(std::size_t index) const {
  const Filter& filter = *filters_[index];
  auto figures = filter.score->summary();
  figures["smoother"] = {{"type", "fixed_interval"}, {"breaks", filter.backward.breaks()}};
  const smooth::Iterations& iterations = filter.backward.iterations();
  if (iterations.wanted == 0) return figures;
  figures["smoother"]["iterations"] = iterations.done;
  figures["smoother"]["converged"] = iterations.converged;
  if (iterations.done > 0) figures["smoother"]["change"] = iterations.change;
  if (!iterations.reason.empty()) figures["smoother"]["reason"] = iterations.reason;
  return figures;
}

}  // namespace binnacle::score
