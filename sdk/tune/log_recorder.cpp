// SPDX-License-Identifier: Apache-2.0
#include "log_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "binnacle/eigen.hpp"
#include "smooth/rows.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;
using Eigen::MatrixXd;

namespace {

/// A Φᵀ.
void times_transposed(const smooth::TransitionPattern& pattern, const double* phi, const MatrixXd& A, MatrixXd& out) {
  out.setZero(A.rows(), A.cols());
  for (int j = 0; j < pattern.n(); ++j)
    for (int k = pattern.first()[as_size(j)]; k < pattern.first()[as_size(j) + 1]; ++k)
      out.col(pattern.rows()[as_size(k)]) += phi[k] * A.col(j);
}

}  // namespace

void carry(const smooth::TransitionPattern& pattern, const double* phi, MatrixXd& A, MatrixXd& scratch) {
  times_transposed(pattern, phi, A, scratch);
  scratch.transposeInPlace();
  times_transposed(pattern, phi, scratch, A);
}

LogRecorder::LogRecorder(const FilterInfo& filter, RecordedRun& run, const Until& until) : run_(run), until_(until) {
  run_.log.consider(smooth::considered_rows(filter));
  PhiT_.setIdentity(filter.dof, filter.dof);
  Q_.setZero(filter.dof, filter.dof);
}

Wants LogRecorder::wants() const {
  return Wants::transition | Wants::jacobian | Wants::reset | Wants::update_covariance;
}

void LogRecorder::forget_steps() {
  first_ = run_.event_of_step.size();
  PhiT_.setIdentity();
  Q_.setZero();
}

void LogRecorder::flush() {
  if (first_ == run_.event_of_step.size()) return;
  for (std::size_t k = first_; k < run_.event_of_step.size(); ++k)
    run_.event_of_step[k] = static_cast<int>(run_.log.events());
  run_.log.add_step(PhiT_.transpose(), Q_);
  forget_steps();
}

void LogRecorder::started(Time t, const double*, ConstMatrixView P) {
  until_.started(t);
  if (until_.is_over(t)) return;
  forget_steps();
  run_.starts.push_back(run_.log.events());
  run_.log.add_start(P);
}

void LogRecorder::stepped(const StepRecord& record) {
  if (until_.is_over(record.t1)) return;
  run_.event_of_step.push_back(-1);
  run_.Phi.resize(run_.Phi.size() + run_.pattern.size());
  double* const phi = run_.Phi.data() + run_.Phi.size() - run_.pattern.size();
  run_.pattern.gather(record.Phi, phi);
  carry(run_.pattern, phi, Q_, scratch_);
  Q_ += record.Qd.as();
  times_transposed(run_.pattern, phi, PhiT_, scratch_);
  PhiT_.swap(scratch_);
}

void LogRecorder::offered(const UpdateRecord& record) {
  if (until_.is_over(record.t)) return;
  const bool is_refused = record.outcome == Outcome::gated || record.outcome == Outcome::rejected;
  if (is_refused || (record.outcome == Outcome::accepted && record.left_out > 0))
    run_.refused.push_back({record.measurement, record.t});
  run_.rows_refused += record.left_out + (is_refused ? record.rows : 0);
  if (record.outcome != Outcome::accepted) return;
  flush();
  const auto m = as_size(record.rows);
  run_.rows += record.rows;
  run_.nis += record.nis;
  run_.accepted.push_back({record.measurement,
                           record.t,
                           {record.row_keys, record.row_keys + m},
                           {record.row_groups, record.row_groups + m},
                           run_.log.events()});
  run_.log.add_update(record.H, record.R, record.update_residual, record.delta, record.reset);
}

void LogRecorder::inflated(const InflationRecord& record) {
  if (until_.is_over(record.t)) return;
  ++run_.recoveries;
  flush();
  if (record.variances)
    run_.log.add_variances(record.variances);
  else
    run_.log.add_start(record.P1);
}

SlopeRecorder::SlopeRecorder(const RecordedRun& run, int dof, double change, const Until& until)
    : run_(run), change_(change), until_(until), terms_(run.log.events()) {
  Q_.setZero(dof, dof);
}

/// What differs by no more than rounding does not depend on the parameter.
void SlopeRecorder::set(std::size_t event, const MatrixXd& noise) {
  const auto base = run_.log.noise(event).as();
  SparseTerm term;
  for (Eigen::Index j = 0; j < noise.cols(); ++j)
    for (Eigen::Index i = j; i < noise.rows(); ++i) {
      const double difference = noise(i, j) - base(i, j);
      const double size = std::sqrt(std::abs(base(i, i) * base(j, j)));
      if (std::abs(difference) <= 64 * std::numeric_limits<double>::epsilon() * size) continue;
      term.at.push_back(static_cast<int>(i + noise.rows() * j));
      term.value.push_back(difference / change_);
    }
  terms_[event] = std::move(term);
}

void SlopeRecorder::started(Time t, const double*, ConstMatrixView P) {
  until_.started(t);
  if (until_.is_over(t)) return;
  if (start_ < run_.starts.size()) set(run_.starts[start_], P.as());
  ++start_;
}

void SlopeRecorder::stepped(const StepRecord& record) {
  if (until_.is_over(record.t1) || step_ >= run_.event_of_step.size()) return;
  const int event = run_.event_of_step[step_];
  if (event >= 0) {
    carry(run_.pattern, run_.Phi.data() + step_ * run_.pattern.size(), Q_, scratch_);
    Q_ += record.Qd.as();
  }
  ++step_;
  const bool is_last = step_ == run_.event_of_step.size() || run_.event_of_step[step_] != event;
  if (!is_last) return;
  if (event >= 0) set(as_size(event), Q_);
  Q_.setZero();
}

void SlopeRecorder::offered(const UpdateRecord& record) {
  if (next_ >= run_.accepted.size()) return;
  const AcceptedSample& sample = run_.accepted[next_];
  if (record.measurement != sample.measurement || record.t != sample.t) return;
  ++next_;
  const auto m = sample.keys.size();
  const bool is_same = record.R && as_size(record.rows) == m &&
                       std::equal(sample.keys.begin(), sample.keys.end(), record.row_keys) &&
                       std::equal(sample.groups.begin(), sample.groups.end(), record.row_groups);
  if (is_same)
    set(sample.event, record.R.as());
  else
    ++missed_;
}

}  // namespace binnacle::tune
