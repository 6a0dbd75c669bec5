// SPDX-License-Identifier: Apache-2.0
// SplineNoise: a smooth random function of time that is known at any instant without running up to it.
#include "spline_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "random/normal.hpp"
#include "simulation/quadrature.hpp"

namespace binnacle::vehicle_simulator {

namespace {

constexpr int order = 6;  // splines that are not zero at an instant
// The density of D′ is f² sinc¹²(fh), whose greatest value lies where π x cot(π x) = 5/6, x = fh.
constexpr double peak = 0.22144;
constexpr std::uint64_t draws_of_coefficient = 64;  // of one coefficient; a normal deviate takes one or, seldom, a few
constexpr std::int64_t nowhere = std::numeric_limits<std::int64_t>::min();

using Weights = std::array<double, order>;

/// The uniform quintic B-splines that overlap at u ∈ [0, 1), the oldest first, times 120; and their derivatives by u.
struct Basis {
  Weights value, first, second;
};

Basis basis(double u) {
  // Coefficients of 1, u, …, u⁵ (C. de Boor, A Practical Guide to Splines, chapter IX, for equally spaced knots).
  static constexpr double c[order][order] = {{1, -5, 10, -10, 5, -1},  {26, -50, 20, 20, -20, 5},
                                             {66, 0, -60, 0, 30, -10}, {26, 50, 20, -20, -20, 10},
                                             {1, 5, 10, 10, 5, -5},    {0, 0, 0, 0, 0, 1}};
  Basis b;
  for (std::size_t i = 0; i < order; ++i) {
    const double* p = c[i];
    b.value[i] = p[0] + u * (p[1] + u * (p[2] + u * (p[3] + u * (p[4] + u * p[5]))));
    b.first[i] = p[1] + u * (2 * p[2] + u * (3 * p[3] + u * (4 * p[4] + u * 5 * p[5])));
    b.second[i] = 2 * p[2] + u * (6 * p[3] + u * (12 * p[4] + u * 20 * p[5]));
  }
  return b;
}

/// Standard deviation of Σ c_k B′(x − k), times 120, over all x.
double slope_deviation() {
  const double variance = simulation::gauss_legendre(0.0, 1.0, [](double u) {
    double sum = 0;
    for (const double weight : basis(u).first) sum += weight * weight;
    return sum;
  });
  return std::sqrt(variance);
}

double coefficient(const random::Philox& beginning, std::int64_t knot) {
  random::Philox stream = beginning;
  stream.discard(draws_of_coefficient * static_cast<std::uint64_t>(knot + order));
  return random::normal(stream);
}

}  // namespace

SplineNoise::SplineNoise(double frequency) : spacing_(peak / frequency), scale_(spacing_ / slope_deviation()) {}

SplineMemory SplineNoise::start(std::uint64_t seed, std::string_view name) {
  return {random::stream(seed, name), nowhere, {}};
}

SplineNoise::Value SplineNoise::at(double t, SplineMemory& memory) const {
  const double x = t / spacing_, whole = std::floor(x);
  const auto knot = static_cast<std::int64_t>(whole);
  if (memory.knot != knot) {
    const bool is_next = memory.knot == knot - 1;
    if (is_next) std::move(memory.coefficient + 1, memory.coefficient + order, memory.coefficient);
    for (int i = is_next ? order - 1 : 0; i < order; ++i)
      memory.coefficient[i] = coefficient(memory.stream, knot - (order - 1) + i);
    memory.knot = knot;
  }
  const Basis b = basis(x - whole);
  Value sum{0, 0, 0};
  for (std::size_t i = 0; i < order; ++i) {
    sum.value += memory.coefficient[i] * b.value[i];
    sum.first += memory.coefficient[i] * b.first[i];
    sum.second += memory.coefficient[i] * b.second[i];
  }
  return {scale_ * sum.value, scale_ / spacing_ * sum.first, scale_ / (spacing_ * spacing_) * sum.second};
}

}  // namespace binnacle::vehicle_simulator
