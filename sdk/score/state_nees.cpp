// SPDX-License-Identifier: Apache-2.0
#include "state_nees.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/state_block.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

/// What rounding leaves of a variance that is none, relative to the largest.
double rounding(int n) { return n * std::numeric_limits<double>::epsilon(); }

}  // namespace

std::optional<double> regular_nees(double* L, const double* delta, double* y, int n, double least) {
  double nees = 0;
  for (int j = 0; j < n; ++j) {
    const double bound = least * L[j + j * n];
    for (int i = j; i < n; ++i) {
      double sum = L[i + j * n];
      for (int k = 0; k < j; ++k) sum -= L[i + k * n] * L[j + k * n];
      if (i == j) {
        if (!(sum > bound)) return std::nullopt;
        L[i + j * n] = std::sqrt(sum);
      } else {
        L[i + j * n] = sum / L[j + j * n];
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    double sum = delta[i];
    for (int k = 0; k < i; ++k) sum -= L[i + k * n] * y[k];
    y[i] = sum / L[i + i * n];
    nees += y[i] * y[i];
  }
  return nees;
}

RankedNees ranked_nees(const double* P, const double* delta, int n) {
  using Vector = Eigen::VectorXd;
  const Eigen::Map<const Eigen::MatrixXd> covariance(P, n, n);
  // Units must not decide about the rank, so components are counted in their own sigma; one of variance 0 in its unit.
  const Vector sigma =
      covariance.diagonal().unaryExpr([](double variance) { return variance > 0 ? std::sqrt(variance) : 1.0; });
  const Vector scale = sigma.cwiseInverse();
  const algebra::Spectrum spectrum = algebra::spectrum(scale.asDiagonal() * covariance * scale.asDiagonal());
  const Vector error = spectrum.vectors.transpose() * scale.cwiseProduct(Eigen::Map<const Vector>(delta, n));
  const double bound = rounding(n) * std::max(1.0, spectrum.values[n - 1]);
  RankedNees ranked;
  for (int i = 0; i < n; ++i) {
    const double variance = spectrum.values[i];
    ranked.rank += variance > bound;
    ranked.nees += error[i] * error[i] / std::max(variance, bound);
  }
  return ranked;
}

int StateNees::add(const BlockInfo& block) {
  if (block.active.empty()) return -1;
  Part part;
  part.block = &block;
  part.first = static_cast<int>(rows_.size());
  parts_.push_back(part);
  for (std::size_t a = 0; a < block.active.size(); ++a) rows_.push_back(block.first_row + static_cast<int>(a));
  const std::size_t n = rows_.size();
  delta_.resize(n);
  y_.resize(n);
  P_.resize(n * n);
  L_.resize(n * n);
  return static_cast<int>(parts_.size()) - 1;
}

void StateNees::take(int index, Time t, std::int64_t changes, const double* delta, ConstMatrixView P) {
  if (t != t_ || changes != changes_) {
    for (Part& part : parts_) part.is_given = false;
    given_ = 0;
    t_ = t;
    changes_ = changes;
  }
  Part& part = parts_[as_size(index)];
  const auto& active = part.block->active;
  for (std::size_t a = 0; a < active.size(); ++a) delta_[as_size(part.first) + a] = delta[active[a]];
  given_ += !part.is_given;
  part.is_given = true;
  if (given_ < parts_.size()) return;
  evaluate(P);
  given_ = 0;
  for (Part& each : parts_) each.is_given = false;
}

void StateNees::evaluate(ConstMatrixView P) {
  const int n = static_cast<int>(rows_.size());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) P_[as_size(i + j * n)] = P(rows_[as_size(i)], rows_[as_size(j)]);
  L_ = P_;
  RankedNees found{0, n};
  if (const auto nees = regular_nees(L_.data(), delta_.data(), y_.data(), n, rounding(n)))
    found.nees = *nees;
  else
    found = ranked_nees(P_.data(), delta_.data(), n);
  nees_.push(t_, found.nees);
  dof_.push(t_, found.rank);
}

std::vector<std::string> StateNees::blocks() const {
  std::vector<std::string> names;
  for (const Part& part : parts_) names.push_back(part.block->name);
  return names;
}

void StateNees::exchange(StateBytes& bytes) {
  bytes.value(given_);
  bytes.value(t_);
  bytes.value(changes_);
  for (Part& part : parts_) bytes.value(part.is_given);
  bytes.list(delta_);
  nees_.exchange(bytes);
  dof_.exchange(bytes);
}

}  // namespace binnacle::score
