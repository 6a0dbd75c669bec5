// SPDX-License-Identifier: Apache-2.0
// Weights of increments over intervals of any lengths.
#include "attitude/interval_weights.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace binnacle::attitude {

namespace {

// Gauss–Legendre with five points on [−1, 1], exact for polynomials of degree 9 (A&S, table 25.4); m_ij needs 8.
constexpr std::array<double, 5> node = {-0.9061798459386639928, -0.5384693101056830910, 0.0, 0.5384693101056830910,
                                        0.9061798459386639928};
constexpr std::array<double, 5> weight = {0.2369268850561890875, 0.4786286704993664680, 0.5688888888888888889,
                                          0.4786286704993664680, 0.2369268850561890875};

using Ends = std::array<double, most_samples + 1>;

/// β_i and β_i′ at t: of each Lagrange polynomial L_m and its derivative, summed over the ends m > i.
struct Shares {
  std::array<double, most_samples> value{}, slope{};

  Shares(const Ends& ends, std::size_t count, double t) {
    for (std::size_t m = 1; m <= count; ++m) {
      double lagrange = 1.0, derivative = 0.0;
      for (std::size_t n = 0; n <= count; ++n) {
        if (n == m) continue;
        const double per = 1.0 / (ends[m] - ends[n]);
        derivative = derivative * (t - ends[n]) * per + lagrange * per;
        lagrange *= (t - ends[n]) * per;
      }
      for (std::size_t i = 0; i < m; ++i) value[i] += lagrange, slope[i] += derivative;
    }
  }
};

}  // namespace

IntervalWeights interval_weights(std::span<const double> lengths) {
  const std::size_t count = lengths.size();
  Ends ends{};
  double sum = 0.0;
  for (const double length : lengths) sum += length;
  for (std::size_t i = 0; i < count; ++i) ends[i + 1] = ends[i] + lengths[i] / sum;

  IntervalWeights w;
  for (std::size_t g = 0; g < node.size(); ++g) {
    const double t = 0.5 * (1.0 + node[g]), dt = 0.5 * weight[g];
    const Shares share(ends, count, t);
    for (std::size_t i = 0; i < count; ++i) {
      w.position[i] += dt * share.value[i];
      for (std::size_t j = 0; j < count; ++j) w.turned[i][j] += dt * (1.0 - t) * share.value[i] * share.slope[j];
      for (std::size_t j = i + 1; j < count; ++j)
        w.pairs.k[i][j] += 0.5 * dt * (share.value[i] * share.slope[j] - share.value[j] * share.slope[i]);
    }
  }
  return w;
}

bool are_equal(std::span<const double> lengths) {
  const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.end());
  constexpr double label = 1.5e-9;  // s: labels are whole nanoseconds
  return *longest - *shortest <= 1e-5 * *longest + label;
}

}  // namespace binnacle::attitude
