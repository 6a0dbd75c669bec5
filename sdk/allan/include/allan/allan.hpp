// SPDX-License-Identifier: Apache-2.0
// Allan variances of a signal as it comes, and the noise terms that they show.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace binnacle::allan {

/// The variance at one averaging time.
struct Point {
  double tau = 0;       // s
  double variance = 0;  // of the signal's unit, squared
  std::int64_t count = 0;
  double seconds = 0;  // over which second differences began
};

/// Allan variances (IEEE 952-1997, C.1) of a signal that is given as means over equal intervals, at averaging times of 1, 2,
/// 3, 4, 6, 8, 12, … intervals: half of the mean square of differences between neighbouring means, fully overlapping up to a
/// stated time, beyond with a stride of at most τ/16. Memory does not grow with the record but with its logarithm.
class Variances {
 public:
  /// full: up to how many intervals averages overlap fully.
  Variances(double interval, std::int64_t full);

  void add(double mean);
  /// What comes next does not join on to what came.
  void interrupt();

  std::int64_t count() const { return count_; }
  /// Those with at least one difference.
  std::vector<Point> points() const;

 private:
  struct Factor {
    std::int64_t m;      // intervals
    std::int64_t steps;  // of its level
    long double sum = 0;
    std::int64_t count = 0;
  };
  /// The integrated signal at each `stride` intervals, as long as its factors need it.
  struct Level {
    std::int64_t stride = 1;
    std::vector<double> ring;
    std::int64_t size = 0;  // samples since the last interruption
    std::vector<Factor> factors;
  };
  void add_factor(std::int64_t m);
  void take(Level& level, double integral);

  double interval_;
  std::int64_t full_, count_ = 0, segment_ = 0;
  double integral_ = 0, first_ = 0;
  std::vector<Level> levels_;
};

/// Terms of noise; coefficients in the units of IEEE 952 (of a signal in u): Q in u s, N in u √s, B in u, K in u/√s, R in u/s.
enum class Term { quantization, white, flicker, random_walk, ramp };
constexpr int term_count = 5;
const char* term_name(Term term);

struct Fit {
  struct Estimate {
    Term term = Term::white;
    double value = 0;                 // the coefficient
    double low = 0, high = 0;         // 95 % of it
    double from_tau = 0, to_tau = 0;  // where it makes up at least a third of the variance
  };
  std::vector<Estimate> estimates;           // those that the record shows
  std::array<double, term_count> largest{};  // of each term that it does not show: what it may be at most (95 %)
  double chi_square = 0;                     // of the residuals, over their degrees of freedom
  int used = 0;                              // averaging times
};

/// What the terms of a fit come to at τ.
double variance_at(const std::vector<Fit::Estimate>& estimates, double tau);

/// Non-negative generalized least squares of σ²(τ) with the covariance that estimates of a record of this length have where
/// the fitted terms hold. A term is there when it raises twice the log-likelihood by more than 9. Averaging times up to a sixth of the record.
Fit fit(const std::vector<Point>& points, double interval);

}  // namespace binnacle::allan
