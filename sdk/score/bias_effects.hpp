// SPDX-License-Identifier: Apache-2.0
// The size of a bias: how far a constant bias of one row of a measurement moves the estimates of a filter, through the gains
// that the filter used (Friedland 1969; Willsky and Jones 1976).
#pragma once

#include <cstdint>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::score {

/// Follows the rows of a filter's watched measurements, each with two hypotheses: a bias since the start, and one since the
/// begin of the present window of 30 s. With s = ∂x̂/∂b, and e the unit vector of the row:
///     s⁻ = Φ s,  g = e − H s⁻,  s⁺ = s⁻ + K g,  J += gᵀ S⁻¹ g,  d += gᵀ S⁻¹ r;
///     b̂ = d / J with the standard deviation 1 / √J, and its effect on the estimates is s b̂.
/// If steps are short, Φ − I of one of them stands for all within 0.1 s. Resets are taken for the identity. Allocates
/// nothing during a run.
class BiasEffects {
 public:
  explicit BiasEffects(const FilterInfo& filter);

  Wants wants() const;
  void started(Time t);
  /// The records up to the newest come again: they are left out.
  void rewound() { seen_until_ = newest_; }
  void stepped(const StepRecord& record);
  void offered(const UpdateRecord& record);
  /// With P of the end.
  void finish(ConstMatrixView P) { close_window(P); }
  void exchange(StateBytes& bytes);

  struct Row {
    std::int64_t key = 0;
    int measurement = 0;
    int group = 0;
    int unseen_at = -1;     // the row of P that a bias of `unseen` moves farthest, in σ
    double unseen = 0;      // found with a probability of 90 % in the newest full window; 0: none was full
    double unseen_for = 0;  // s, the window
    double unseen_effect = 0, unseen_in_sigma = 0;
  };
  /// Rows beyond the first 32 are not followed.
  const std::vector<Row>& rows() const { return rows_; }
  /// Null: it is not followed.
  const Row* find(int measurement, int group, std::int64_t key) const;
  /// Upper bounds (95 %) of the effect on a row of P: the largest of all windows, in the unit of the row and over 3 σ.
  struct Effect {
    double largest = 0, of_3_sigma = 0;
  };
  Effect effect(const Row& row, int of) const { return effects_[place(&row - rows_.data(), of)]; }
  /// The largest 1-σ of a row of P at the end of a window.
  double largest_sigma(int of) const { return largest_sigma_[static_cast<std::size_t>(of)]; }

 private:
  static constexpr std::size_t most_rows = 32, stride = 2 * most_rows;

  std::size_t place(std::ptrdiff_t row, int of) const {
    return static_cast<std::size_t>(row) * coupled_.size() + static_cast<std::size_t>(of);
  }
  double* s(int row) { return s_.data() + static_cast<std::size_t>(row) * stride; }
  double* g(int row) { return g_.data() + static_cast<std::size_t>(row) * stride; }
  std::size_t columns() const { return 2 * rows_.size(); }
  bool is_window_over() const;
  void whiten(const UpdateRecord& record);
  void close_window(ConstMatrixView P);
  void see_effects(std::size_t column, ConstMatrixView P);
  void see_unseen(std::size_t row, ConstMatrixView P);

  const FilterInfo& filter_;
  std::vector<std::vector<int>> coupled_;  // by row of P: columns of Φ that are not zero; none: the row stays as it is
  Time newest_ = no_time, seen_until_ = no_time, propagated_ = no_time, window_begin_ = no_time, long_begin_ = no_time;
  Time step_ = 0;          // the length of the newest
  std::vector<Row> rows_;  // row i has the columns 2 i (since the start) and 2 i + 1 (of the window)
  std::vector<double> s_, J_, d_;
  std::vector<Effect> effects_;
  std::vector<double> largest_sigma_;
  std::vector<double> next_, g_, residual_, factor_;  // scratch
};

}  // namespace binnacle::score
