// SPDX-License-Identifier: Apache-2.0
// Gauss–Legendre quadrature on an interval.
#pragma once

#include <array>
#include <cstddef>

namespace binnacle::simulation {

/// Abscissae on [−1, 1] and weights, from A&S (Abramowitz and Stegun) table 25.4; exact for polynomials of
/// degree 2n − 1.
struct Gauss2 {
  static constexpr std::size_t count = 2;
  static constexpr std::array<double, count> node = {-0.5773502691896257645, 0.5773502691896257645};
  static constexpr std::array<double, count> weight = {1.0, 1.0};
};
struct Gauss5 {
  static constexpr std::size_t count = 5;
  static constexpr std::array<double, count> node = {-0.9061798459386639928, -0.5384693101056830910, 0.0,
                                                     0.5384693101056830910, 0.9061798459386639928};
  static constexpr std::array<double, count> weight = {0.2369268850561890875, 0.4786286704993664680,
                                                       0.5688888888888888889, 0.4786286704993664680,
                                                       0.2369268850561890875};
};
struct Gauss8 {
  static constexpr std::size_t count = 8;
  static constexpr std::array<double, count> node = {-0.9602898564975362317, -0.7966664774136267396,
                                                     -0.5255324099163289858, -0.1834346424956498049,
                                                     0.1834346424956498049,  0.5255324099163289858,
                                                     0.7966664774136267396,  0.9602898564975362317};
  static constexpr std::array<double, count> weight = {0.1012285362903762592, 0.2223810344533744705,
                                                       0.3137066458778872873, 0.3626837833783619830,
                                                       0.3626837833783619830, 0.3137066458778872873,
                                                       0.2223810344533744705, 0.1012285362903762592};
};

/// Calls visit(t, w) for every abscissa t of [a, b] with its weight.
template <class Rule, class Visit>
void for_each_node(double a, double b, Visit&& visit) {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  for (std::size_t i = 0; i < Rule::count; ++i) visit(middle + half * Rule::node[i], half * Rule::weight[i]);
}

/// ∫ f over [a, b] with eight points.
template <class Function>
double gauss_legendre(double a, double b, Function&& f) {
  double sum = 0.0;
  for_each_node<Gauss8>(a, b, [&](double t, double w) { sum += w * f(t); });
  return sum;
}

}  // namespace binnacle::simulation
