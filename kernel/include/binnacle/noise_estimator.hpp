// SPDX-License-Identifier: Apache-2.0
// NoiseEstimator: how far a measurement is trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/result.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// What the estimator is bound to: the largest row count, and the groups of rows (the parts of a stack, or one).
struct NoiseBinding {
  int max_rows = 0;
  std::vector<int> group_first_row;  // of a sample that has all of its rows; else see Innovation::row_groups
  std::vector<NamedUnit> groups;     // name and unit of its rows
};

/// One innovation as an estimator sees it. All m×m matrices are views into kernel memory.
struct Innovation {
  Time t = no_time;
  double dt = 0;  // since this measurement's last accepted sample [s]; 0 at the first
  int rows = 0;
  std::span<const std::int64_t> row_keys;
  std::span<const int> row_groups;   // whose row it is: index into NoiseBinding::groups, ascending
  const double* residual = nullptr;  // r, before the update
  MatrixView HPHt;                   // H P⁻ Hᵀ
  MatrixView R_nominal;
};

enum class Outcome { accepted, gated, late, unsupported, invalid, withheld, rejected };
inline constexpr int outcome_count = 7;

/// Replaces the nominal R by an estimate. Its memory is rolled back when the sample is gated, unless the config says
/// `learn_from_gated`. Constructor: (const Binding&, const NoiseBinding&). Immutable; never throws, never allocates.
class NoiseEstimator {
 public:
  virtual ~NoiseEstimator() = default;

  virtual std::size_t memory_bytes() const noexcept = 0;
  virtual void start(std::byte* /*memory*/) const {}
  /// Writes R (rows×rows, symmetric, positive semidefinite); it holds R_nominal on entry.
  virtual void estimate(const Innovation& innovation, std::byte* memory, MatrixView R) const = 0;
  /// After the update: the outcome, the post-fit residual and H P⁺ Hᵀ. Called only when wants_after().
  virtual bool wants_after() const noexcept { return false; }
  virtual void after(Outcome /*outcome*/, const double* /*post_fit_residual*/, MatrixView /*HPHt_plus*/,
                     std::byte* /*memory*/) const {}
};

}  // namespace binnacle
