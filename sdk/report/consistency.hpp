// SPDX-License-Identifier: Apache-2.0
// Whether a filter is as good as it thinks: shares within its own σ, and χ² bounds.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace binnacle::report {

/// How many of the errors with a σ above zero lie within k σ.
struct Within {
  std::size_t one = 0, two = 0, three = 0;
  std::size_t of = 0;

  void add(double error, double sigma);
  void add(const Within& other);
};
Within within_sigma(std::span<const double> errors, std::span<const double> sigma);

/// What 95 % of χ² of so many degrees of freedom lie between; {0, 0} of none.
std::pair<double, double> chi_squared_95(double dof);

/// What 99 % of means of n independent χ² lie between.
std::pair<double, double> mean_chi_squared_99(double dof, double n);

/// Means over up to `count` values each, one after the other.
struct MovingMean {
  std::vector<double> t, mean;
  double low = 0, high = 0;  // 95 % of such means lie between if they are χ² of the dof
};

/// Values that come one by one, for such means of all of them. In memory that does not grow with them: beyond a number that is
/// far beyond what needs longer means, only sums over as many as a mean takes are kept, and of very many those of two together.
class MovingSums {
 public:
  void add(double t, double value);
  MovingMean mean(double mean_dof) const;

 private:
  struct Stretch {
    double first = 0, last = 0;  // times
    double sum = 0;
    std::size_t n = 0;
  };
  static void append(std::vector<Stretch>& stretches, const Stretch& value, std::size_t each);

  std::size_t n_ = 0;
  std::size_t each_ = 1;  // values of a stretch
  std::vector<Stretch> stretches_;
};
MovingMean moving_mean(std::span<const double> t, std::span<const double> values, double mean_dof);

}  // namespace binnacle::report
