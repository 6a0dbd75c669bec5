// SPDX-License-Identifier: Apache-2.0
#include "smooth/stretch.hpp"

#include <algorithm>
#include <cmath>

#include "binnacle/state_block.hpp"
#include "wording/block_call.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

using namespace wording;

Stretch::Stretch(const Session& session, FilterId filter, const TransitionPattern& pattern, bool has_considered)
    : session_(session),
      id_(filter),
      filter_(session.composition().filters()[as_size(filter.index)]),
      pattern_(pattern),
      has_considered_(has_considered),
      x_(as_size(filter_.stored_size)),
      delta_(as_size(filter_.dof)),
      P_(as_size(filter_.dof) * as_size(filter_.dof)) {
  for (const BlockInfo& block : filter_.blocks)
    block_delta_.resize(std::max(block_delta_.size(), as_size(block.declaration->dof())));
}

Wants Stretch::wants() const {
  const Wants always = Wants::transition | Wants::jacobian | Wants::reset;
  return wanted_.empty() && !take_path_ ? always : always | Wants::step_covariance;
}

double* Stretch::add(Kind kind, std::size_t doubles, Time t) {
  entries_.push_back({kind, 0, false, t, numbers_.size()});
  numbers_.resize(numbers_.size() + doubles);
  return numbers_.data() + entries_.back().at;
}

double* Stretch::keep(double* to, ConstMatrixView A) {
  MatrixView{to, A.rows, A.cols, A.rows}.as() = A.as();
  return to + A.rows * A.cols;
}

void Stretch::clear() {
  entries_.clear();
  numbers_.clear();
  withheld_.clear();
  decisions_.clear();
}

bool Stretch::is_wanted(Time t0, Time t1) const {
  const auto next = std::ranges::lower_bound(wanted_, t0);
  return next != wanted_.end() && *next < t1;
}

void Stretch::started(Time t, const double* x, ConstMatrixView P) {
  if (t > session_.start_time(id_)) {
    was_opened_ = true;
    add(Kind::cut, 0);
  }
  if (take_path_) add_mark(Kind::path, t, x, P, nullptr);
}

void Stretch::stepped(const StepRecord& record) {
  const bool wanted = is_wanted(record.t0, record.t1);
  if (wanted) mark(record.t0, record.x0, record.P0);
  add_step(record);
  if (take_path_) add_mark(Kind::path, record.t1, record.x1, record.P1, nullptr);
  if (wanted) mark(record.t1, record.x1, record.P1);
}

void Stretch::add_step(const StepRecord& record) {
  const std::size_t of_noise = has_considered_ ? P_.size() : 0;
  double* const to = add(Kind::step, pattern_.size() + of_noise);
  pattern_.gather(record.Phi, to);
  if (has_considered_) keep(to + pattern_.size(), record.Qd);
}

void Stretch::offered(const UpdateRecord& record) {
  if (take_path_) decisions_.note(record);
  if (record.outcome == Outcome::withheld) withhold(record, session_.covariance(id_));
  if (record.outcome == Outcome::accepted) add_update(record);
}

void Stretch::add_update(const UpdateRecord& record) {
  const auto n = as_size(filter_.dof), m = as_size(record.rows);
  double* to = add(Kind::update, 2 * n * m + 2 * m * m + m + (record.reset ? n * n : 0));
  entries_.back().rows = record.rows;
  entries_.back().has_reset = static_cast<bool>(record.reset);
  for (const ConstMatrixView& A : {record.H, record.K, record.update_S, record.R}) to = keep(to, A);
  to = std::copy_n(record.update_residual, m, to);
  if (record.reset) keep(to, record.reset);
}

void Stretch::inflated(const InflationRecord& record) {
  was_opened_ = true;
  if (record.variances)
    std::copy_n(record.variances, filter_.dof, add(Kind::variances, as_size(filter_.dof)));
  else
    add(Kind::cut, 0);
}

void Stretch::mark(Time t, const double* x, ConstMatrixView P, const double* deviation) {
  add_mark(Kind::mark, t, x, P, deviation);
}

void Stretch::mark_path(const PathFilter& filter, Time t) {
  add_mark(Kind::path, t, filter.x(), filter.covariance(), filter.deviation());
}

void Stretch::add_mark(Kind kind, Time t, const double* x, ConstMatrixView P, const double* deviation) {
  double* const to = keep(std::copy_n(x, x_.size(), add(kind, x_.size() + P_.size() + delta_.size(), t)), P);
  if (deviation)
    std::copy_n(deviation, delta_.size(), to);
  else
    std::fill_n(to, delta_.size(), 0.0);
}

void Stretch::withhold(const UpdateRecord& record, ConstMatrixView P) {
  const auto n = as_size(filter_.dof), m = as_size(record.rows);
  double* const to = add(Kind::withheld, n * m + n * n, record.t);
  entries_.back().rows = static_cast<int>(withheld_.size());
  keep(keep(to, record.H), P);
  withheld_.push_back({record.measurement,
                       record.t,
                       {record.residual, record.residual + m},
                       {record.row_groups, record.row_groups + m}});
}

WithheldSample Stretch::withheld(const Entry& entry, CoStates& co_states) {
  WithheldSample sample = std::move(withheld_[as_size(entry.rows)]);
  const int n = filter_.dof, m = static_cast<int>(sample.residual.size());
  const double* const from = numbers_.data() + entry.at;
  const ConstMatrixView H{from, m, n, m}, P{from + n * m, n, n, n};
  co_states.correction(P, delta_.data());
  VectorView(sample.residual.data(), m).as() -= H.as() * ConstVectorView(delta_.data(), n).as();
  return sample;
}

void Stretch::exchange(StateBytes& bytes) {
  bytes.list(entries_);
  bytes.list(numbers_);
  bytes.list(withheld_, [&](WithheldSample& sample) {
    bytes.value(sample.measurement);
    bytes.value(sample.t);
    bytes.list(sample.residual);
    bytes.list(sample.groups);
  });
  bytes.value(breaks_);
  bytes.value(was_opened_);
}

void Stretch::sweep(CoStates& co_states, const Take& take, const TakeWithheld& take_withheld, Window window) {
  const int n = filter_.dof;
  for (auto last = entries_.rbegin(); last != entries_.rend(); ++last) {  // clang before 16 has no std::views
    const Entry& entry = *last;
    const double* const from = numbers_.data() + entry.at;
    switch (entry.kind) {
      case Kind::step:
        co_states.step(from, has_considered_ ? ConstMatrixView{from + pattern_.size(), n, n, n} : ConstMatrixView());
        break;
      case Kind::update: co_states.update(terms_of(entry)); break;
      case Kind::variances: co_states.inflate(from); break;
      case Kind::cut: breaks_ += co_states.clear(); break;
      case Kind::mark:
        if (window.contains(entry.t)) take(smoothed(entry, co_states));
        break;
      case Kind::path:
        move(entry, co_states);
        note_change({from + x_.size(), n, n, n});
        take_path_(x_.data());
        break;
      case Kind::withheld:
        if (window.contains(entry.t)) take_withheld(withheld(entry, co_states));
        break;
    }
  }
}

UpdateTerms Stretch::terms_of(const Entry& entry) const {
  const double* from = numbers_.data() + entry.at;
  const auto next = [&](int rows, int columns) {
    const ConstMatrixView A{from, rows, columns, rows};
    from += rows * columns;
    return A;
  };
  const int n = filter_.dof, m = entry.rows;
  UpdateTerms terms;
  terms.H = next(m, n);
  terms.K = next(n, m);
  terms.S = next(m, m);
  terms.R = next(m, m);
  terms.residual = next(m, 1).data;
  if (entry.has_reset) terms.reset = next(n, n);
  return terms;
}

void Stretch::move(const Entry& entry, CoStates& co_states) {
  const int n = filter_.dof;
  const double* const x = numbers_.data() + entry.at;
  const double* const P = x + x_.size();
  co_states.correction({P, n, n, n}, delta_.data());
  const double* const deviation = P + P_.size();
  for (std::size_t i = 0; i < delta_.size(); ++i) delta_[i] += deviation[i];
  std::copy_n(x, x_.size(), x_.data());
  for (const BlockInfo& block : filter_.blocks) {
    if (block.active.empty()) continue;
    const int stored = block.declaration->stored_size;
    const VectorView delta(block_delta_.data(), block.declaration->dof());
    std::fill_n(delta.data(), delta.size(), 0.0);
    for (std::size_t a = 0; a < block.active.size(); ++a) delta[block.active[a]] = delta_[as_size(block.first_row) + a];
    double* const value = x_.data() + block.stored_offset;
    call_block(block, "plus", entry.t, [&] {
      block.block->plus(ConstVectorView(x + block.stored_offset, stored), delta, VectorView(value, stored));
    });
  }
}

Epoch Stretch::smoothed(const Entry& entry, CoStates& co_states) {
  const int n = filter_.dof;
  const MatrixView P{P_.data(), n, n, n};
  move(entry, co_states);
  co_states.covariance({numbers_.data() + entry.at + x_.size(), n, n, n}, P);
  return {entry.t, x_.data(), P};
}

void Stretch::note_change(ConstMatrixView P) {
  for (int i = 0; i < P.rows; ++i)
    if (P(i, i) > 0) largest_change_ = std::max(largest_change_, std::abs(delta_[as_size(i)]) / std::sqrt(P(i, i)));
}

}  // namespace binnacle::smooth
