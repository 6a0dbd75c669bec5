// SPDX-License-Identifier: Apache-2.0
#include "smooth/path.hpp"

#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "algebra/decompositions.hpp"
#include "binnacle/state_block.hpp"
#include "smooth/stretch.hpp"
#include "wording/block_call.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

using namespace wording;

// ---- decisions

void Decisions::note(const UpdateRecord& record) {
  Kind kind = unused;
  if (record.outcome == Outcome::withheld) kind = withheld;
  if (record.outcome == Outcome::accepted) kind = record.left_out > 0 ? part : whole;
  kinds_.push_back(kind);
  if (kind != part) return;
  rows_.push_back({0, record.rows});
  for (int i = 0; i < record.rows; ++i) rows_.push_back({record.row_groups[i], record.row_keys[i]});
}

void Decisions::append(const Decisions& later) {
  kinds_.insert(kinds_.end(), later.kinds_.begin(), later.kinds_.end());
  rows_.insert(rows_.end(), later.rows_.begin(), later.rows_.end());
}

std::size_t Decisions::next_rows(std::size_t& first) const {
  const auto count = static_cast<std::size_t>(rows_[first].key);
  first += 1 + count;
  return first - count;
}

// ---- the path

PathFile::PathFile(int stored_size) : file_(std::tmpfile()), size_(as_size(stored_size) * sizeof(double)) {
  if (!file_) throw std::runtime_error("there is no room for a temporary file, which smoothing needs");
}

void PathFile::write(const double* x) {
  if (pwrite(fileno(file_.get()), x, size_, count_ * static_cast<off_t>(size_)) != static_cast<ssize_t>(size_))
    throw std::runtime_error("the temporary file of a smoother cannot be written: is the disk full?");
  ++count_;
}

bool PathFile::read(std::int64_t index, double* x) const {
  if (index < 0 || index >= count_) return false;
  const auto at = (count_ - 1 - index) * static_cast<off_t>(size_);
  return pread(fileno(file_.get()), x, size_, at) == static_cast<ssize_t>(size_);
}

// ---- the filter of the deviations

PathFilter::PathFilter(const FilterInfo& filter, std::vector<unsigned char> considered)
    : filter_(filter), considered_(std::move(considered)) {
  const auto n = filter.dof;
  for (auto* x : {&x_, &next_x_}) x->resize(as_size(filter.stored_size));
  for (const BlockInfo& block : filter.blocks)
    block_delta_.resize(std::max(block_delta_.size(), as_size(block.declaration->dof())));
  for (auto* vector : {&delta_, &defect_}) vector->setZero(n);
  for (auto* square : {&P_, &scratch_}) square->setZero(n, n);
}

void PathFilter::begin(const PathFile& path, const Decisions& decisions) {
  path_ = &path;
  decisions_ = &decisions;
  trouble_.clear();
  index_ = -1;
  sample_ = row_ = 0;
}

void PathFilter::restore(const Snapshot& snapshot) {
  index_ = snapshot.index;
  sample_ = snapshot.sample;
  row_ = snapshot.row;
  delta_ = snapshot.delta;
  P_ = snapshot.P;
  if (index_ >= 0) read_path(index_, x_);
}

ConstMatrixView PathFilter::covariance() const { return {P_.data(), filter_.dof, filter_.dof, filter_.dof}; }

void PathFilter::read_path(std::int64_t index, std::vector<double>& x) {
  if (!path_->read(index, x.data())) trouble_ = "its steps are not those of the first run";
}

void PathFilter::minus(const double* y, const double* x, Time t, Eigen::VectorXd& delta) {
  for (const BlockInfo& block : filter_.blocks) {
    if (block.active.empty()) continue;
    const int stored = block.declaration->stored_size, at = block.stored_offset;
    const VectorView difference(block_delta_.data(), block.declaration->dof());
    call_block(block, "minus", t, [&] {
      block.block->minus(ConstVectorView(y + at, stored), ConstVectorView(x + at, stored), difference);
    });
    for (std::size_t a = 0; a < block.active.size(); ++a)
      delta[block.first_row + static_cast<int>(a)] = difference[block.active[a]];
  }
}

void PathFilter::started(Time t, const double* x, ConstMatrixView P) {
  if (index_ >= 0) {
    trouble_ = "it starts anew";
    return;
  }
  index_ = 0;
  read_path(0, x_);
  if (!trouble_.empty()) return;
  minus(x, x_.data(), t, delta_);
  P_ = P.as();
  if (stretch_) stretch_->mark_path(*this, t);
}

void PathFilter::stepped(const StepRecord& record) {
  if (!trouble_.empty()) return;
  read_path(index_ + 1, next_x_);
  if (!trouble_.empty()) return;
  const bool is_wanted = stretch_ && stretch_->is_wanted(record.t0, record.t1);
  if (is_wanted) stretch_->mark(record.t0, x_.data(), covariance(), delta_.data());
  const auto Phi = record.Phi.as();
  minus(record.x1, next_x_.data(), record.t1, defect_);
  defect_.noalias() += Phi * delta_;
  scratch_.noalias() = Phi * P_;
  P_.noalias() = scratch_ * Phi.transpose();
  P_ += record.Qd.as();
  delta_.swap(defect_);
  x_.swap(next_x_);
  ++index_;
  if (!stretch_) return;
  stretch_->add_step(record);
  stretch_->mark_path(*this, record.t1);
  if (is_wanted) stretch_->mark(record.t1, x_.data(), covariance(), delta_.data());
}

void PathFilter::offered(const UpdateRecord& record) {
  if (!trouble_.empty()) return;
  if (sample_ >= decisions_->size()) {
    trouble_ = "its samples are not those of the first run";
    return;
  }
  const Decisions::Kind kind = (*decisions_)[sample_++];
  const std::size_t first = kind == Decisions::part ? decisions_->next_rows(row_) : row_;
  if (kind == Decisions::unused) return;
  if (!choose_rows(record, kind, first)) {
    trouble_ = "a sample of '" + filter_.measurements[as_size(record.measurement)].name +
               "' that was used cannot be linearized along the path";
    return;
  }
  if (kind == Decisions::withheld) {
    UpdateRecord withheld = record;
    withheld.residual = r_.data();
    if (stretch_) stretch_->withhold(withheld, covariance());
  } else {
    update(record);
  }
}

/// H, R and r − H δ of the rows that were used. False where there are not all of them.
bool PathFilter::choose_rows(const UpdateRecord& record, Decisions::Kind kind, std::size_t first) {
  if (!record.H) return false;
  chosen_.clear();
  for (int i = 0; i < record.rows && kind != Decisions::part; ++i) chosen_.push_back(i);
  for (std::size_t k = first; k < row_; ++k)
    for (int i = 0; i < record.rows; ++i)
      if (decisions_->row(k) == Decisions::Row{record.row_groups[i], record.row_keys[i]}) chosen_.push_back(i);
  if (kind == Decisions::part && chosen_.size() != row_ - first) return false;
  const auto m = static_cast<Eigen::Index>(chosen_.size());
  H_.resize(m, filter_.dof);
  R_.resize(m, m);
  r_.resize(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const int row = chosen_[static_cast<std::size_t>(i)];
    H_.row(i) = record.H.as().row(row);
    r_[i] = record.residual[row];
    for (Eigen::Index j = 0; j < m; ++j) R_(i, j) = record.R(row, chosen_[static_cast<std::size_t>(j)]);
  }
  r_.noalias() -= H_ * delta_;
  return m > 0;
}

void PathFilter::update(const UpdateRecord& record) {
  const auto m = static_cast<int>(H_.rows()), n = filter_.dof;
  const Eigen::MatrixXd HP = H_ * P_;
  S_ = HP * H_.transpose() + R_;
  const algebra::Cholesky factor(S_);
  if (!factor.is_positive()) {
    trouble_ = "H P H' + R is not positive definite along the path";
    return;
  }
  K_ = factor.solve(HP).transpose();
  for (std::size_t i = 0; i < considered_.size(); ++i)
    if (considered_[i]) K_.row(static_cast<Eigen::Index>(i)).setZero();
  delta_.noalias() += K_ * r_;
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n) - K_ * H_;
  P_ = (A * P_ * A.transpose() + K_ * R_ * K_.transpose()).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  if (!stretch_) return;
  UpdateRecord used = record;
  used.outcome = Outcome::accepted;
  used.rows = m;
  used.H = {H_.data(), m, n, m};
  used.K = {K_.data(), n, m, n};
  used.update_S = {S_.data(), m, m, m};
  used.R = {R_.data(), m, m, m};
  used.update_residual = r_.data();
  stretch_->add_update(used);
}

}  // namespace binnacle::smooth
