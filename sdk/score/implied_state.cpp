// SPDX-License-Identifier: Apache-2.0
#include "implied_state.hpp"

#include <algorithm>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/state_block.hpp"
#include "wording/block_call.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

ImpliedState::ImpliedState(const ImpliedStatePlan& plan, const BlockInfo& block)
    : plan_(plan),
      block_(block),
      rows_(static_cast<int>(block.active.size())),
      value_(as_size(block.declaration->stored_size)),
      covariance_(block.active.size() * block.active.size()),
      delta_(as_size(block.declaration->dof())) {}

bool ImpliedState::take(const UpdateRecord& record, ConstMatrixView P) {
  if (record.measurement != plan_.measurement || !record.H) return false;
  if (record.outcome != Outcome::accepted && record.outcome != Outcome::withheld) return false;
  const MatrixXd H = record.H.as();
  const MatrixXd B = algebra::left_inverse(H.middleCols(block_.first_row, rows_), record.R.as());
  if (B.size() == 0) return false;
  const VectorXd d = B * vector_at(record.update_residual, record.rows);
  std::fill(delta_.begin(), delta_.end(), 0.0);
  for (std::size_t a = 0; a < block_.active.size(); ++a)
    delta_[as_size(block_.active[a])] = d[static_cast<Eigen::Index>(a)];
  const ConstVectorView x(record.x0 + block_.stored_offset, block_.declaration->stored_size);
  call_block(block_, "plus", record.t, [&] { block_.block->plus(x, delta_, value_); });
  MatrixXd E = -B * H;
  E.middleCols(block_.first_row, rows_) += MatrixXd::Identity(rows_, rows_);
  covariance().as() = E * P.as() * E.transpose() + B * record.R.as() * B.transpose();
  t_ = record.t;
  return true;
}

}  // namespace binnacle::score
