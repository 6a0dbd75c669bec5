// SPDX-License-Identifier: Apache-2.0
// UpdateFigures: what a page says of all samples of a measurement, however many of them it draws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "consistency.hpp"
#include "results/results.hpp"

namespace binnacle::report {

class UpdateFigures {
 public:
  struct Row {
    Within within;  // of the residuals that were accepted, by their √S
    double least_noise = 0, greatest_noise = 0;
    std::size_t n = 0;
  };

  void add(double t, Outcome outcome, const std::string& reason, double nis, std::int32_t rows);
  /// Of the sample that was added last.
  void add_row(std::int32_t group, std::int64_t key, double residual, double sigma, double noise);

  std::size_t samples() const { return samples_; }
  const std::array<std::size_t, outcome_count>& counts() const { return counts_; }
  /// By outcome and reason.
  const std::map<std::pair<int, std::string>, std::size_t>& reasons() const { return reasons_; }
  /// Samples with a NIS; of these the accepted ones, and their rows.
  std::size_t with_nis() const { return with_nis_; }
  std::size_t accepted() const { return accepted_; }
  double mean_dof() const { return static_cast<double>(accepted_rows_) / static_cast<double>(accepted_); }
  double mean_nis() const { return nis_sum_ / static_cast<double>(accepted_); }
  /// How many of the accepted lie within 95 % of χ².
  std::size_t inside() const { return inside_; }
  /// These bounds, by the rows of a sample.
  const std::map<std::int32_t, std::pair<double, double>>& bounds() const { return bounds_; }
  MovingMean moving_mean() const { return moving_.mean(mean_dof()); }
  /// By group and key.
  const std::map<std::pair<std::int32_t, std::int64_t>, Row>& rows() const { return rows_; }

 private:
  std::size_t samples_ = 0, with_nis_ = 0, accepted_ = 0, accepted_rows_ = 0, inside_ = 0;
  double nis_sum_ = 0;
  std::array<std::size_t, outcome_count> counts_{};
  std::map<std::pair<int, std::string>, std::size_t> reasons_;
  std::map<std::int32_t, std::pair<double, double>> bounds_;
  MovingSums moving_;
  Outcome outcome_ = Outcome::accepted;
  std::map<std::pair<std::int32_t, std::int64_t>, Row> rows_;
};

UpdateFigures figures_of(const results::Updates& updates);

}  // namespace binnacle::report
