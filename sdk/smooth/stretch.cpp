// SPDX-License-Identifier: Apache-2.0
#include "smooth/stretch.hpp"

#include <algorithm>
#include <ranges>

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
  return wanted_.empty() ? always : always | Wants::step_covariance;
}

double* Stretch::add(Kind kind, std::size_t doubles, Time t) {
  entries_.push_back({kind, 0, false, t, numbers_.size()});
  numbers_.resize(numbers_.size() + doubles);
  return numbers_.data() + entries_.back().at;
}

double* Stretch::keep(double* to, ConstMatrixView A) {
  MatrixView(to, A.rows, A.cols, A.rows).as() = A.as();
  return to + A.rows * A.cols;
}

void Stretch::clear() {
  entries_.clear();
  numbers_.clear();
  withheld_.clear();
}

void Stretch::started(Time t, const double*, ConstMatrixView) {
  if (t > session_.start_time(id_)) add(Kind::cut, 0);
}

void Stretch::stepped(const StepRecord& record) {
  const auto next = std::ranges::lower_bound(wanted_, record.t0);
  const bool is_wanted = next != wanted_.end() && *next < record.t1;
  if (is_wanted) mark(record.t0, record.x0, record.P0);
  const std::size_t of_noise = has_considered_ ? P_.size() : 0;
  double* const to = add(Kind::step, pattern_.size() + of_noise);
  pattern_.gather(record.Phi, to);
  if (has_considered_) keep(to + pattern_.size(), record.Qd);
  if (is_wanted) mark(record.t1, record.x1, record.P1);
}

void Stretch::offered(const UpdateRecord& record) {
  if (record.outcome == Outcome::withheld) withhold(record);
  if (record.outcome != Outcome::accepted) return;
  const auto n = as_size(filter_.dof), m = as_size(record.rows);
  double* to = add(Kind::update, 2 * n * m + 2 * m * m + m + (record.reset ? n * n : 0));
  entries_.back().rows = record.rows;
  entries_.back().has_reset = static_cast<bool>(record.reset);
  for (const ConstMatrixView& A : {record.H, record.K, record.S, record.R}) to = keep(to, A);
  to = std::copy_n(record.residual, m, to);
  if (record.reset) keep(to, record.reset);
}

void Stretch::inflated(const InflationRecord& record) {
  if (record.variances)
    std::copy_n(record.variances, filter_.dof, add(Kind::variances, as_size(filter_.dof)));
  else
    add(Kind::cut, 0);
}

void Stretch::mark(Time t, const double* x, ConstMatrixView P) {
  double* const to = add(Kind::mark, x_.size() + P_.size(), t);
  keep(std::copy_n(x, x_.size(), to), P);
}

/// P is that before the sample, which changes nothing.
void Stretch::withhold(const UpdateRecord& record) {
  const auto n = as_size(filter_.dof), m = as_size(record.rows);
  double* const to = add(Kind::withheld, n * m + n * n, record.t);
  entries_.back().rows = static_cast<int>(withheld_.size());
  keep(keep(to, record.H), session_.covariance(id_));
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

void Stretch::sweep(CoStates& co_states, const Take& take, const TakeWithheld& take_withheld) {
  const int n = filter_.dof;
  for (const Entry& entry : entries_ | std::views::reverse) {
    const double* const from = numbers_.data() + entry.at;
    switch (entry.kind) {
      case Kind::step:
        co_states.step(from, has_considered_ ? ConstMatrixView{from + pattern_.size(), n, n, n} : ConstMatrixView());
        break;
      case Kind::update: co_states.update(terms_of(entry)); break;
      case Kind::variances: co_states.inflate(from); break;
      case Kind::cut: breaks_ += co_states.clear(); break;
      case Kind::mark: take(smoothed(entry, co_states)); break;
      case Kind::withheld: take_withheld(withheld(entry, co_states)); break;
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

Epoch Stretch::smoothed(const Entry& entry, CoStates& co_states) {
  const int n = filter_.dof;
  const double* const x = numbers_.data() + entry.at;
  const ConstMatrixView P{x + x_.size(), n, n, n};
  const MatrixView of_smoothed{P_.data(), n, n, n};
  co_states.correction(P, delta_.data());
  co_states.covariance(P, of_smoothed);
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
  return {entry.t, x_.data(), of_smoothed};
}

}  // namespace binnacle::smooth
