// SPDX-License-Identifier: Apache-2.0
// What is kept of a record's rows while a run goes on, in memory that does not grow with them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace binnacle::report {

/// Of one quantity and its 1-σ: the rows where either is least or greatest in each stretch of so many rows, as a plot of all would be
/// seen by. Stretches become twice as long whenever there are too many; short of that, all rows are kept.
class ThinnedSeries {
 public:
  /// At least 16 points.
  explicit ThinnedSeries(std::size_t most_points);
  /// The rows that come next; all of one length. sigma: may be empty.
  void add(std::span<const double> t, std::span<const double> values, std::span<const double> sigma);
  /// The last row too, where there is one.
  void finish();

  const std::vector<double>& t() const { return t_; }
  const std::vector<double>& values() const { return values_; }
  /// NaN where there was none.
  const std::vector<double>& sigma() const { return sigma_; }
  struct Columns {
    std::vector<double> t, values, sigma;
  };
  Columns taken() && { return {std::move(t_), std::move(values_), std::move(sigma_)}; }

 private:
  void keep(std::size_t row, double t, double value, double sigma);
  void make_room();
  void thin();

  std::size_t most_, width_ = 1, rows_ = 0;
  bool are_parts_ = false;  // of stretches, each thinned by itself
  std::vector<std::uint64_t> row_;
  std::vector<double> t_, values_, sigma_;
  double last_t_ = 0, last_value_ = 0, last_sigma_ = 0;
};

/// Of a place on a plane: rows at least `step` from the one kept before. The step becomes twice as long whenever they are too
/// many; short of that, all are kept.
class ThinnedPath {
 public:
  /// `scale_*`: metres of one unit of x and y.
  ThinnedPath(std::size_t most_points, double scale_x, double scale_y);
  void add(double t, double x, double y, double sigma_x, double sigma_y);
  void finish();

  const std::vector<double>& t() const { return t_; }
  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& y() const { return y_; }
  const std::vector<double>& sigma_x() const { return sigma_x_; }
  const std::vector<double>& sigma_y() const { return sigma_y_; }

 private:
  bool is_apart(std::size_t from, double x, double y) const;
  void thin();

  std::size_t most_;
  double scale_x_, scale_y_, step_ = 0;
  std::vector<double> t_, x_, y_, sigma_x_, sigma_y_;
  bool is_last_kept_ = true;
  double last_[5] = {};
};

}  // namespace binnacle::report
