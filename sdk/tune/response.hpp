// SPDX-License-Identifier: Apache-2.0
// What a parameter does to a filter: to its noise alone, and by which law, or to more than that.
#pragma once

#include <cstdint>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"
#include "smooth/co_states.hpp"

namespace binnacle::tune {

/// none: nothing depends on it. square, linear: P₀, Qd and R are affine in θ², in θ, and nothing else depends on it.
/// curved: they depend on it otherwise. other: Φ, H, residuals or the state do.
enum class Law { none, square, linear, curved, other };

/// Of a run that withholds every sample, so that noise does not touch the path: the path to the bit, and sums of the noise.
class Response final : public StepObserver {
 public:
  explicit Response(const FilterInfo& filter);

  Wants wants() const override { return Wants::transition | Wants::jacobian; }
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;

  std::uint64_t path() const { return path_; }
  /// P₀, Σ Qd, and Σ R by measurement.
  const std::vector<double>& noise() const { return noise_; }
  /// Where R begins in it.
  std::size_t first_R() const { return 2 * static_cast<std::size_t>(n_ * n_); }
  /// √(A_ii A_jj) of the same: what rounding is measured by.
  const std::vector<double>& size() const { return size_; }

 private:
  void take(const double* numbers, std::size_t count);
  void take(ConstMatrixView A);
  void add(ConstMatrixView A, std::size_t at, int ld);

  int n_, stored_size_;
  std::uint64_t path_ = 14695981039346656037u;
  std::vector<double> noise_, size_;
  std::vector<std::size_t> of_measurement_;  // where its R is in noise_
  std::vector<int> max_rows_;
};

/// Whether R differs.
bool differ_in_R(const std::vector<const Response*>& a, const std::vector<const Response*>& b);

/// By the responses at θ, 2 θ and 4 θ (each of every filter and config).
Law law_of(const std::vector<const Response*>& once, const std::vector<const Response*>& twice,
           const std::vector<const Response*>& four_times);

}  // namespace binnacle::tune
