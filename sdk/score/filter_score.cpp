// SPDX-License-Identifier: Apache-2.0
#include "filter_score.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "binnacle/eigen.hpp"
#include "wording/block_call.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

/// One series for each error component and norm of a kind of block.
std::vector<Series> error_series(const StateBlockDeclaration& declaration, const std::string& prefix) {
  std::vector<Series> all;
  for (const auto& component : declaration.error) {
    const auto& display = declaration.error_display_unit.empty() ? component.unit : declaration.error_display_unit;
    all.push_back({prefix + "." + component.name, component.unit, display, {}, {}});
  }
  for (const auto& norm : declaration.norms) {
    const auto first = as_size(norm.components.front());
    all.push_back({prefix + "." + norm.name, all[first].unit, all[first].display_unit, {}, {}});
  }
  return all;
}

void push_errors(std::vector<Series>& series, const StateBlockDeclaration& declaration, Time t, const double* delta) {
  std::size_t index = 0;
  for (std::size_t c = 0; c < declaration.error.size(); ++c) series[index++].push(t, delta[c]);
  for (const auto& norm : declaration.norms) {
    double squares = 0;
    for (const int c : norm.components) squares += delta[c] * delta[c];
    series[index++].push(t, std::sqrt(squares));
  }
}

/// The first row of a group in a sample, and how many there are.
std::pair<int, int> rows_of(const UpdateRecord& record, int group) {
  const auto [first, last] = std::equal_range(record.row_groups, record.row_groups + record.rows, group);
  return {static_cast<int>(first - record.row_groups), static_cast<int>(last - first)};
}

}  // namespace

// ---- before the run

FilterScore::FilterScore(const ScorePlan& plan, int filter)
    : plan_(plan),
      filter_(filter),
      info_(plan.filters[as_size(filter)]),
      jumps_(info_),
      gates_(info_),
      first_samples_(info_) {
  size_scratch();
  if (std::ranges::any_of(info_.measurements, &MeasurementInfo::is_watched))
    effects_ = std::make_unique<BiasEffects>(info_);
  for (const auto& implied_state : plan.implied_states[as_size(filter)])
    implied_states_.emplace_back(implied_state, info_.blocks[as_size(implied_state.block)]);
  add_references();
  add_state();
  for (std::size_t m = 0; m < info_.measurements.size(); ++m) {
    add_withheld(static_cast<int>(m));
    if (info_.measurements[m].noise.object) add_noise(static_cast<int>(m));
  }
  add_subjects();
}

FilterScore::FilterScore(const ScorePlan& plan, const SmoothingPlan& smoothing)
    : plan_(plan),
      filter_(smoothing.as),
      info_(plan.filters[as_size(smoothing.as)]),
      jumps_(info_),
      gates_(info_),
      first_samples_(info_) {
  size_scratch();
  add_references();
  add_state();
  for (std::size_t m = 0; m < info_.measurements.size(); ++m) add_withheld(static_cast<int>(m));
  add_subjects();
}

bool FilterScore::refers_to(int channel) const {
  return std::ranges::any_of(references_,
                             [&](const Reference& reference) { return reference.plan->channel == channel; });
}

void FilterScore::size_scratch() {
  std::size_t dof = 1, stored = 1, outputs = 1;
  for (const auto& block : info_.blocks) {
    dof = std::max(dof, as_size(block.declaration->dof()));
    stored = std::max(stored, as_size(block.declaration->stored_size));
    outputs = std::max(outputs, block.declaration->outputs.size());
  }
  delta_.resize(dof);
  between_.resize(stored);
  truth_.resize(stored);
  outputs_.resize(outputs);
  covariance_.resize(dof * (dof + 2));
}

void FilterScore::add_references() {
  for (const auto& reference : plan_.references) {
    if (reference.filter != filter_) continue;
    if (reference.block >= 0)
      add_channel_reference(reference);
    else
      scored_measurements_.insert(reference.measurement);
  }
}

void FilterScore::add_channel_reference(const ReferencePlan& plan) {
  const auto& block = plan.implied_state < 0
                          ? info_.blocks[as_size(plan.block)]
                          : plan_.implied_states[as_size(filter_)][as_size(plan.implied_state)].value;
  const auto& declaration = *block.declaration;
  Reference reference;
  reference.plan = &plan;
  reference.block = &block;
  reference.name = block.name;
  reference.is_whole = std::all_of(plan.fields.begin(), plan.fields.end(), [](int field) { return field >= 0; });
  if (reference.is_whole) reference.series = error_series(declaration, block.name);
  for (std::size_t i = 0; i < declaration.outputs.size(); ++i) {
    const auto& output = declaration.outputs[i];
    const std::string name = block.name + "." + output.name;
    const bool is_there = index_of(names_of(reference.series), name) >= 0;
    if (plan.fields[i] < 0 || !output.is_scored || is_there) {
      reference.output_series.push_back(-1);
      continue;
    }
    reference.output_series.push_back(static_cast<int>(reference.series.size()));
    reference.series.push_back(
        {name, output.unit, output.display_unit.empty() ? output.unit : output.display_unit, {}, {}});
  }
  references_.push_back(std::move(reference));
  is_of_reference_.resize(std::max(is_of_reference_.size(), as_size(plan.channel) + 1));
  is_of_reference_[as_size(plan.channel)] = 1;
}

/// A block with several references is given by the first.
void FilterScore::add_state() {
  if (index_of(names_of(info_.blocks), state_name) >= 0) return;
  std::set<const BlockInfo*> given;
  for (auto& reference : references_)
    if (reference.is_whole && reference.plan->implied_state < 0 && given.insert(reference.block).second)
      reference.state_part = state_nees_.add(*reference.block);
}

void FilterScore::add_withheld(int measurement) {
  const MeasurementInfo& info = info_.measurements[as_size(measurement)];
  for (std::size_t index = 0; index < info.groups.size(); ++index) {
    const auto& group = info.groups[index];
    if (group.kind.empty()) continue;
    WithheldGroup entry;
    entry.measurement = measurement;
    entry.group = static_cast<int>(index);
    if (group.like >= 0) {
      const BlockInfo& like = info_.blocks[as_size(group.like)];
      entry.norms = like.declaration;
      entry.series = error_series(*like.declaration, like.name);
    } else {
      entry.series.push_back({info.name + "." + group.kind, group.unit, group.unit, {}, {}});
    }
    withheld_.push_back(std::move(entry));
  }
}

void FilterScore::add_noise(int measurement) {
  const MeasurementInfo& info = info_.measurements[as_size(measurement)];
  for (std::size_t index = 0; index < info.groups.size(); ++index) {
    const auto& group = info.groups[index];
    if (group.kind.empty()) continue;
    const std::string shown = group.like < 0 ? "" : info_.blocks[as_size(group.like)].declaration->error_display_unit;
    NoiseGroup entry;
    entry.measurement = measurement;
    entry.group = static_cast<int>(index);
    entry.series = {info.name + (info.groups.size() > 1 ? "." + group.name : "") + ".noise",
                    group.unit,
                    shown.empty() ? group.unit : shown,
                    {},
                    {}};
    noise_.push_back(std::move(entry));
  }
}

void FilterScore::add_subjects() {
  std::set<std::string> names;
  const auto add = [&](const Series& series, int reference, std::size_t index) {
    if (names.insert(series.name).second) subjects_.push_back({&series, reference, static_cast<int>(index)});
  };
  for (std::size_t r = 0; r < references_.size(); ++r)
    for (std::size_t i = 0; i < references_[r].series.size(); ++i)
      add(references_[r].series[i], static_cast<int>(r), i);
  for (const auto& group : withheld_)
    if (scored_measurements_.contains(group.measurement))
      for (const auto& series : group.series) add(series, -1, 0);
  for (const auto& group : noise_) add(group.series, -1, 0);
}

void FilterScore::attach(Session& session, StepObserver* next) {
  session_ = &session;
  next_ = next;
  session.attach({filter_}, this);
}

void FilterScore::watch_only() {
  has_state_nees_ = false;
  for (auto& reference : references_) {
    reference.has_nees = false;
    reference.is_watched = !reference.sigmas.empty();
  }
}

void FilterScore::watch(const Metric& metric) {
  if (metric.quantity == MetricQuantity::nis) return;
  if (metric.quantity == MetricQuantity::segments) return watch_track(metric.subject);
  if (metric.nees_of == NeesOf::state) {
    has_state_nees_ = true;
    for (auto& reference : references_) reference.is_watched |= reference.state_part >= 0;
  } else if (metric.nees_of == NeesOf::block) {
    auto& reference = references_[as_size(metric.subject)];
    reference.has_nees = reference.is_watched = true;
  } else if (const int index = subjects_[as_size(metric.subject)].reference; index >= 0) {
    references_[as_size(index)].is_watched = true;
    if (metric.quantity != MetricQuantity::error) keep_sigmas(references_[as_size(index)]);
  }
}

void FilterScore::keep_sigmas() {
  for (auto& reference : references_) keep_sigmas(reference);
}

void FilterScore::keep_sigmas(Reference& reference) {
  reference.sigmas.resize(reference.series.size());
  const auto& block = *reference.block;
  sigma_scratch_.resize(std::max(sigma_scratch_.size(), output_sigma_scratch(block)));
  sigmas_.resize(std::max(sigmas_.size(), block.declaration->outputs.size()));
}

// ---- during the run

bool FilterScore::read(const ReferencePlan& plan, const SampleView& sample, Pending& pending) const {
  pending.t = sample.t;
  pending.values.assign(plan.fields.size(), 0.0);
  bool is_given = false, is_finite = true;
  for (std::size_t k = 0; k < plan.fields.size(); ++k) {
    if (plan.fields[k] < 0) continue;
    pending.values[k] = sample.fields[plan.fields[k]];
    is_finite = is_finite && std::isfinite(pending.values[k]);
    is_given = is_given || !plan.invalid || pending.values[k] != *plan.invalid;
  }
  return is_given && is_finite;
}

void FilterScore::reference(int channel, const SampleView& sample) {
  if (as_size(channel) >= is_of_reference_.size() || !is_of_reference_[as_size(channel)]) return;
  for (std::size_t i = 0; i < references_.size(); ++i) {
    const auto& plan = *references_[i].plan;
    if (plan.channel != channel || !references_[i].is_watched) continue;
    if ((session_ && !session_->started(FilterId{filter_})) || sample.t < start()) continue;
    Pending pending;
    pending.reference = static_cast<int>(i);
    if (!read(plan, sample, pending)) continue;
    if (plan.implied_state >= 0) {
      pending_of_implied_states_.push_back(pending);
      score_implied_state(plan.implied_state);
      continue;
    }
    // The filter may have passed this instant already: then only an estimate at that very time will do.
    if (session_ && sample.t == session_->time(FilterId{filter_}) && info_.input_channel < 0) {
      score(pending, session_->state(FilterId{filter_}).data());
      continue;
    }
    pending_.push_back(pending);
  }
}

void FilterScore::started(Time t, const double* x, ConstMatrixView P) {
  if (next_) next_->started(t, x, P);
  if (effects_) effects_->started(t);
}

void FilterScore::stepped(const StepRecord& record) {
  ++changes_;
  if (next_) next_->stepped(record);
  if (effects_) effects_->stepped(record);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    if (pending_[i].t < record.t0) continue;
    if (pending_[i].t >= record.t1) {
      pending_[kept++] = pending_[i];
      continue;
    }
    const auto& block = info_.blocks[as_size(references_[as_size(pending_[i].reference)].plan->block)];
    const int stored = block.declaration->stored_size;
    const ConstVectorView x0(record.x0 + block.stored_offset, stored), x1(record.x1 + block.stored_offset, stored);
    const VectorView delta(delta_.data(), block.declaration->dof()), between(between_.data(), stored);
    const double fraction = seconds(pending_[i].t - record.t0) / seconds(record.t1 - record.t0);
    call_block(block, "minus", pending_[i].t, [&] { block.block->minus(x1, x0, delta); });
    delta.as() *= fraction;
    call_block(block, "plus", pending_[i].t, [&] { block.block->plus(x0, delta, between); });
    score_block(pending_[i], between.data(), record.P0);
  }
  pending_.resize(kept);
}

void FilterScore::offered(const UpdateRecord& record) {
  ++changes_;
  if (next_) next_->offered(record);
  if (effects_) effects_->offered(record);
  if (is_again(record.t)) return;
  jumps_.offered(record);
  gates_.offered(record);
  first_samples_.offered(record);
  for (std::size_t r = 0; r < implied_states_.size(); ++r)
    if (implied_states_[r].take(record, record.P0 ? record.P0 : session_->covariance(FilterId{filter_})))
      score_implied_state(static_cast<int>(r));
  if (record.outcome == Outcome::withheld)
    score_withheld(record);
  else
    keep_noise(record);
}

void FilterScore::finish() {
  if (effects_ && session_ && session_->started(FilterId{filter_}))
    effects_->finish(session_->covariance(FilterId{filter_}));
  for (const auto& pending : pending_)
    if (session_ && pending.t == session_->time(FilterId{filter_}))
      score(pending, session_->state(FilterId{filter_}).data());
  pending_.clear();
  pending_of_implied_states_.clear();
}

void FilterScore::exchange(StateBytes& bytes) {
  bytes.value(changes_);
  bytes.value(newest_);
  bytes.value(seen_until_);
  jumps_.exchange(bytes);
  gates_.exchange(bytes);
  first_samples_.exchange(bytes);
  if (effects_) effects_->exchange(bytes);
  for (auto& reference : references_) {
    for (auto& series : reference.series) series.exchange(bytes);
    reference.nees.exchange(bytes);
    for (auto& sigmas : reference.sigmas) bytes.list(sigmas);
  }
  state_nees_.exchange(bytes);
  for (auto& watched : tracks_) watched.track.exchange(bytes);
  for (auto& group : withheld_)
    for (auto& series : group.series) series.exchange(bytes);
  for (auto& group : noise_) group.series.exchange(bytes);
  for (auto* list : {&pending_, &pending_of_implied_states_})
    bytes.list(*list, [&](Pending& pending) {
      bytes.value(pending.reference);
      bytes.value(pending.t);
      bytes.list(pending.values);
    });
  for (auto& implied_state : implied_states_) implied_state.exchange(bytes);
}

void FilterScore::score_withheld(const UpdateRecord& record) {
  for (auto& group : withheld_) {
    if (group.measurement != record.measurement) continue;
    const auto [first, rows] = rows_of(record, group.group);
    if (rows < 1 || (group.norms && rows < group.norms->dof())) continue;
    if (group.norms) {
      push_errors(group.series, *group.norms, record.t, record.residual + first);
      continue;
    }
    double squares = 0;
    for (int i = 0; i < rows; ++i) squares += record.residual[first + i] * record.residual[first + i];
    group.series[0].push(record.t, std::sqrt(squares / std::max(1, rows)));
  }
}

void FilterScore::keep_noise(const UpdateRecord& record) {
  if (!record.R || record.outcome == Outcome::rejected) return;
  for (auto& group : noise_) {
    if (group.measurement != record.measurement) continue;
    const auto [first, rows] = rows_of(record, group.group);
    if (rows < 1) continue;
    double sum = 0;
    for (int i = 0; i < rows; ++i) sum += record.R(first + i, first + i);
    group.series.push(record.t, std::sqrt(sum / rows));
  }
}

void FilterScore::score(const Pending& pending, const double* state) {
  const auto& block = *references_[as_size(pending.reference)].block;
  score_block(pending, state + block.stored_offset, session_->covariance(FilterId{filter_}));
}

/// An implied state is of its instant: only a reference of that very time shows whether it is right.
void FilterScore::score_implied_state(int index) {
  auto& implied_state = implied_states_[as_size(index)];
  std::erase_if(pending_of_implied_states_, [&](const Pending& pending) {
    if (references_[as_size(pending.reference)].plan->implied_state != index) return false;
    if (pending.t == implied_state.t()) score_block(pending, implied_state.value(), implied_state.covariance());
    return pending.t <= implied_state.t();
  });
}

/// P: a posteriori at the last update before the reference, or at its very time.
void FilterScore::score_block(const Pending& pending, const double* estimate, ConstMatrixView P) {
  auto& reference = references_[as_size(pending.reference)];
  const auto& block = *reference.block;
  const auto& declaration = *block.declaration;
  const bool keeps_sigmas = !reference.sigmas.empty();
  const ConstVectorView at(estimate, declaration.stored_size);
  if (reference.is_whole) {
    const VectorView truth(truth_.data(), declaration.stored_size);
    if (!call_block(block, "write", pending.t, [&] { return block.block->write(pending.values, truth); })) return;
    call_block(block, "minus", pending.t, [&] { block.block->minus(truth, at, {delta_.data(), declaration.dof()}); });
    push_errors(reference.series, declaration, pending.t, delta_.data());
    if (keeps_sigmas) push_error_sigmas(reference, P);
    if (reference.has_nees) score_consistency(reference, pending.t, P);
    if (!tracks_.empty()) take_poses(pending, truth_.data());
    if (has_state_nees_ && reference.state_part >= 0)
      state_nees_.take(reference.state_part, pending.t, changes_, delta_.data(), P);
  }
  const VectorView outputs(outputs_.data(), static_cast<int>(declaration.outputs.size()));
  call_block(block, "read", pending.t, [&] { block.block->read(at, outputs); });
  if (keeps_sigmas)
    call_block(block, "plus and read, for its 1-sigma", pending.t,
               [&] { output_sigmas(block, estimate, P, sigma_scratch_.data(), sigmas_.data()); });
  for (std::size_t i = 0; i < declaration.outputs.size(); ++i) {
    if (reference.output_series[i] < 0) continue;
    const auto series = as_size(reference.output_series[i]);
    double difference = pending.values[i] - outputs_[i];
    if (declaration.outputs[i].is_angle) difference = std::remainder(difference, 2 * std::numbers::pi);
    reference.series[series].push(pending.t, difference);
    if (keeps_sigmas) reference.sigmas[series].push_back(sigmas_[i]);
  }
}

/// The 1-σ of errors and norms, in the order of push_errors(). The variance of a norm is the sum of its components'.
void FilterScore::push_error_sigmas(Reference& reference, ConstMatrixView P) {
  const BlockInfo& block = *reference.block;
  std::vector<double> variances(block.declaration->error.size(), 0.0);
  for (std::size_t a = 0; a < block.active.size(); ++a) {
    const int row = block.first_row + static_cast<int>(a);
    variances[as_size(block.active[a])] = P(row, row);
  }
  std::size_t index = 0;
  for (const double variance : variances) reference.sigmas[index++].push_back(std::sqrt(variance));
  for (const auto& norm : block.declaration->norms) {
    double sum = 0;
    for (const int c : norm.components) sum += variances[as_size(c)];
    reference.sigmas[index++].push_back(std::sqrt(sum));
  }
}

/// NEES of the active components; left out where P is singular.
void FilterScore::score_consistency(Reference& reference, Time t, ConstMatrixView P) {
  const BlockInfo& block = *reference.block;
  const int n = static_cast<int>(block.active.size());
  if (n == 0) return;
  double* const L = covariance_.data();
  double* const delta = L + n * n;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) L[i + j * n] = P(block.first_row + i, block.first_row + j);
    delta[j] = delta_[as_size(block.active[as_size(j)])];
  }
  if (const auto nees = regular_nees(L, delta, delta + n, n, 0)) reference.nees.push(t, *nees);
}

// ---- what a record shows beside the estimates

std::vector<RecordColumn> FilterScore::implied_state_columns() const {
  std::vector<RecordColumn> columns;
  for (const auto& implied_state : implied_states_) {
    const auto& value = implied_state.plan().value;
    for (const char* suffix : {"", ".sigma"})
      for (const auto& output : value.declaration->outputs)
        columns.push_back({value.name + "." + output.name + suffix, output.unit});
  }
  return columns;
}

void FilterScore::latest_implied_states(Time t, double* values) {
  for (auto& implied_state : implied_states_) {
    const auto& value = implied_state.plan().value;
    const auto count = value.declaration->outputs.size();
    if (implied_state.t() == t) {
      std::vector<double> scratch(output_sigma_scratch(value));
      call_block(value, "plus and read", t, [&] {
        value.block->read({implied_state.value(), value.declaration->stored_size}, {values, static_cast<int>(count)});
        output_sigmas(value, implied_state.value(), implied_state.covariance(), scratch.data(), values + count);
      });
    } else {
      std::fill_n(values, 2 * count, not_a_number);
    }
    values += 2 * count;
  }
}

std::vector<RecordColumn> FilterScore::noise_columns() const {
  std::vector<RecordColumn> columns;
  for (const auto& group : noise_) columns.push_back({group.series.name, group.series.unit});
  return columns;
}

void FilterScore::latest_noise(double* values) const {
  for (const auto& group : noise_) *values++ = group.series.values.empty() ? not_a_number : group.series.values.back();
}

}  // namespace binnacle::score
