// SPDX-License-Identifier: Apache-2.0
// What a page keeps of a run while it goes on: extremes, paths, moving means.
#include "thinned_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "catch.hpp"
#include "consistency.hpp"
#include "results/row_block.hpp"

namespace thinned_test {

using namespace binnacle::report;

namespace {

using Numbers = std::vector<double>;

struct Rows {
  Numbers t, values, sigma;
};

Rows noisy(std::size_t n) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Rows rows;
  for (std::size_t i = 0; i < n; ++i) {
    rows.t.push_back(0.01 * static_cast<double>(i));
    rows.values.push_back(std::sin(1e-3 * static_cast<double>(i)) + 0.1 * normal(random));
    rows.sigma.push_back(1 + 0.1 * normal(random));
  }
  return rows;
}

ThinnedSeries thinned(const Rows& rows, std::size_t most, std::size_t block) {
  ThinnedSeries series(most);
  for (std::size_t begin = 0; begin < rows.t.size(); begin += block) {
    const std::size_t n = std::min(block, rows.t.size() - begin);
    series.add({rows.t.data() + begin, n}, {rows.values.data() + begin, n}, {rows.sigma.data() + begin, n});
  }
  series.finish();
  return series;
}

}  // namespace

TEST_CASE("a series is kept whole as long as it may be drawn whole") {
  const Rows rows = noisy(1000);
  const auto series = thinned(rows, 1000, 64);
  CHECK(series.t() == rows.t);
  CHECK(series.values() == rows.values);
  CHECK(series.sigma() == rows.sigma);
}

TEST_CASE("of a long series the extremes of every stretch are kept, whatever the blocks it came in") {
  const Rows rows = noisy(200'000);
  for (const std::size_t block : {1U, 64U, 1000U, 8192U}) {
    const auto series = thinned(rows, 2000, block);
    REQUIRE(series.t().size() <= 2001);
    REQUIRE(series.t().size() > 500);
    CHECK(series.t().front() == rows.t.front());
    CHECK(series.t().back() == rows.t.back());
    CHECK(std::is_sorted(series.t().begin(), series.t().end()));
    // No stretch of the longest that may be has an extreme that is not there: 200 000 rows in 2000 / 4 / 2 stretches at least.
    const std::size_t stretch = 1024;
    for (std::size_t begin = 0; begin + stretch <= rows.t.size(); begin += stretch) {
      const auto has = [&](const Numbers& of, const Numbers& kept, bool is_least) {
        const auto first = of.begin() + static_cast<std::ptrdiff_t>(begin), last = first + stretch;
        const double extreme = is_least ? *std::min_element(first, last) : *std::max_element(first, last);
        return std::find(kept.begin(), kept.end(), extreme) != kept.end();
      };
      for (const bool is_least : {true, false}) {
        REQUIRE(has(rows.values, series.values(), is_least));
        REQUIRE(has(rows.sigma, series.sigma(), is_least));
      }
    }
  }
}

TEST_CASE("a series passes over what is no number") {
  Rows rows = noisy(50'000);
  for (std::size_t i = 100; i < rows.t.size(); i += 7) rows.values[i] = std::nan("");
  rows.values[33'333] = 1e3;
  rows.sigma[44'444] = -1e3;
  const auto series = thinned(rows, 1000, 512);
  CHECK(std::count(series.values().begin(), series.values().end(), 1e3) == 1);
  CHECK(std::count(series.sigma().begin(), series.sigma().end(), -1e3) == 1);
  for (auto& value : rows.values) value = std::nan("");
  CHECK(thinned(rows, 1000, 512).t().size() <= 1001);
}

TEST_CASE("a path is kept whole while it is short, then by distance, its ends always") {
  ThinnedPath whole(1000, 1, 1), path(1000, 2, 1);
  double x = 0;
  for (int i = 0; i < 900; ++i) whole.add(i, i, 0, 1, 1);
  whole.finish();
  CHECK(whole.t().size() == 900);
  for (int i = 0; i < 100'000; ++i) {
    x += i / 1000 % 2 ? 0 : 0.5;  // goes, and stands
    path.add(i, x, -x, 1, 2);
  }
  path.finish();
  REQUIRE(path.t().size() <= 1001);
  REQUIRE(path.t().size() > 400);
  CHECK(path.t().front() == 0);
  CHECK(path.t().back() == 99'999);
  CHECK(path.sigma_y().front() == 2);
  for (std::size_t i = 1; i < path.t().size(); ++i)
    CHECK(std::hypot(2 * (path.x()[i] - path.x()[i - 1]), path.y()[i] - path.y()[i - 1]) <
          2 * std::hypot(2, 1) * x / 400);
}

TEST_CASE("a path without numbers does not grow either") {
  ThinnedPath path(100, 1, 1);
  for (int i = 0; i < 10'000; ++i) path.add(i, std::nan(""), 0, 1, 1);
  CHECK(path.t().size() <= 100);
}

TEST_CASE("moving means of what comes one by one are those of all at once") {
  std::mt19937 random(5);
  std::chi_squared_distribution<double> chi(3);
  for (const std::size_t n : {std::size_t{19}, std::size_t{20}, std::size_t{5000}, std::size_t{12'799},
                              std::size_t{12'800}, std::size_t{100'000}}) {
    MovingSums sums;
    Numbers t, values;
    for (std::size_t i = 0; i < n; ++i) {
      t.push_back(static_cast<double>(i));
      values.push_back(chi(random));
      sums.add(t.back(), values.back());
    }
    const std::size_t count = std::clamp<std::size_t>(n / 60, 10, 200);
    const auto moving = sums.mean(3);
    REQUIRE(moving.mean.size() == (n < 2 * count ? 0 : n / count));
    for (std::size_t m = 0; m < moving.mean.size(); ++m) {
      double sum = 0;
      for (std::size_t i = 0; i < count; ++i) sum += values[m * count + i];
      CHECK(moving.mean[m] == sum / static_cast<double>(count));
      CHECK(moving.t[m] == (t[m * count] + t[m * count + count - 1]) / 2);
    }
  }
}

TEST_CASE("a block of rows, column by column") {
  using binnacle::results::ColumnBlock;
  binnacle::results::RowBlock rows;
  for (int r = 0; r < 37; ++r) {
    rows.t.push_back(r * 5'000'000);
    for (int c = 0; c < 5; ++c) rows.values.push_back(100 * r + c);
  }
  ColumnBlock columns;
  columns.take(rows, 5);
  REQUIRE(columns.rows() == 37);
  for (std::size_t r = 0; r < 37; ++r) {
    CHECK(columns.t()[r] == 5 * static_cast<double>(r) / 1000);
    for (std::size_t c = 0; c < 5; ++c) CHECK(columns.column(c)[r] == static_cast<double>(100 * r + c));
  }
  CHECK(binnacle::results::rows_of_block(43) == 8192);
  CHECK(binnacle::results::rows_of_block(400) == 1024);
}

}  // namespace thinned_test
