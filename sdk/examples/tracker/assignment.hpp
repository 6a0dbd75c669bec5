// SPDX-License-Identifier: Apache-2.0
// Which detection belongs to which target, at the least total cost.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

/// The assignment problem in fixed memory: H. W. Kuhn, "The Hungarian method for the assignment problem", Naval Research
/// Logistics Quarterly 2, 1955, in the form with potentials and shortest augmenting paths (R. Jonker, A. Volgenant,
/// Computing 38, 1987).
///
/// Every row gets one column, no column twice, so that the sum of the costs is least. Columns are at least as many as
/// rows.
template <std::size_t MostRows, std::size_t MostColumns>
class Assignment {
 public:
  Assignment(std::size_t rows, std::size_t columns) : rows_(rows), columns_(columns) {}

  double& cost(std::size_t row, std::size_t column) { return cost_[row * MostColumns + column]; }

  /// The column of each row.
  std::array<std::size_t, MostRows> solve() {
    for (std::size_t row = 1; row <= rows_; ++row) add(row);
    std::array<std::size_t, MostRows> column_of{};
    for (std::size_t j = 1; j <= columns_; ++j)
      if (row_of_[j] != none) column_of[row_of_[j] - 1] = j - 1;
    return column_of;
  }

 private:
  // Rows and columns are counted from 1 here; 0 stands for none, and column 0 for where a path begins.
  static constexpr std::size_t none = 0;

  /// One more row: along the cheapest path of exchanges to a column that is still free.
  void add(std::size_t row) {
    std::array<double, MostColumns + 1> least;
    std::array<bool, MostColumns + 1> is_done{};
    least.fill(std::numeric_limits<double>::infinity());
    row_of_[0] = row;
    std::size_t here = 0;
    while (row_of_[here] != none) {
      is_done[here] = true;
      const std::size_t next = nearest(row_of_[here], here, is_done, least);
      const double step = least[next];
      for (std::size_t j = 0; j <= columns_; ++j) {
        if (is_done[j])
          row_price_[row_of_[j]] += step, column_price_[j] -= step;
        else
          least[j] -= step;
      }
      here = next;
    }
    for (; here != 0; here = came_from_[here]) row_of_[here] = row_of_[came_from_[here]];
  }

  /// The column not done yet that is reached at the least reduced cost, after looking from `row`.
  std::size_t nearest(std::size_t row, std::size_t here, const std::array<bool, MostColumns + 1>& is_done,
                      std::array<double, MostColumns + 1>& least) {
    std::size_t best = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    for (std::size_t j = 1; j <= columns_; ++j) {
      if (is_done[j]) continue;
      const double reduced = cost(row - 1, j - 1) - row_price_[row] - column_price_[j];
      if (reduced < least[j]) least[j] = reduced, came_from_[j] = here;
      if (least[j] < best_cost) best_cost = least[j], best = j;
    }
    return best;
  }

  std::size_t rows_, columns_;
  std::array<double, MostRows * MostColumns> cost_{};
  std::array<double, MostRows + 1> row_price_{};
  std::array<double, MostColumns + 1> column_price_{};
  std::array<std::size_t, MostColumns + 1> row_of_{}, came_from_{};
};
