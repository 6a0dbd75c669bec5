// SPDX-License-Identifier: Apache-2.0
// Allan variances against their definition, and the terms of known noises: how often the truth lies in the band, and how wide
// it is.
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "allan/allan.hpp"
#include "catch.hpp"

namespace allan_test {

using namespace binnacle::allan;

namespace {

constexpr double interval = 0.01;

std::vector<double> white(std::size_t count, double N, std::mt19937& random) {
  std::normal_distribution<double> normal(0, N / std::sqrt(interval));
  std::vector<double> y(count);
  for (double& value : y) value = normal(random);
  return y;
}

void add_random_walk(std::vector<double>& y, double K, std::mt19937& random) {
  // Means over intervals of a Wiener process.
  std::normal_distribution<double> normal;
  double level = 0;
  for (double& value : y) {
    const double a = normal(random), b = normal(random);
    const double step = K * std::sqrt(interval) * a;
    value += level + 0.5 * step + K * std::sqrt(interval / 12) * b;
    level += step;
  }
}

/// One-sided density of the means over intervals of 1/f noise, B² / (π f): what lies beyond the Nyquist frequency folds back.
double flicker_density(double f, double B) {
  const double pi = std::acos(-1.0), sine = std::sin(pi * f * interval);
  double sum = 0;
  for (int k = -20; k <= 20; ++k) {
    const double folded = std::abs(f + k / interval), u = pi * folded * interval;
    sum += B * B / (pi * folded) * sine * sine / (u * u);
  }
  return sum;
}

/// From its spectrum, twice as long as what is used.
void add_flicker(std::vector<double>& y, double B, std::mt19937& random) {
  std::size_t size = 1;
  while (size < 2 * y.size()) size *= 2;
  const auto n = static_cast<double>(size);
  std::normal_distribution<double> normal;
  std::vector<std::complex<double>> spectrum(size, 0.0);
  for (std::size_t k = 1; k <= size / 2; ++k) {
    const double scale = std::sqrt(flicker_density(static_cast<double>(k) / (n * interval), B) / 4 * n / interval);
    spectrum[k] = {scale * normal(random), k < size / 2 ? scale * normal(random) : 0.0};
    spectrum[size - k] = std::conj(spectrum[k]);
  }
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> signal;
  fft.inv(signal, spectrum);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += signal[k].real();
}

void add_quantization(std::vector<double>& y, double Q, std::mt19937& random) {
  std::normal_distribution<double> normal(0, Q);
  double last = normal(random);
  for (double& value : y) {
    const double next = normal(random);
    value += (next - last) / interval;
    last = next;
  }
}

Fit fit_of(const std::vector<double>& y) {
  Variances variances(interval, 100);
  for (const double value : y) variances.add(value);
  return fit(variances.points(), interval);
}

}  // namespace

TEST_CASE("fully overlapping variances are those of the definition, and those with a stride of the same differences") {
  std::mt19937 random(1);
  auto y = white(5000, 0.1, random);
  add_random_walk(y, 0.3, random);
  Variances variances(interval, 64);
  // Two parts that do not join on to each other.
  const std::size_t cut = 2100;
  for (std::size_t k = 0; k < y.size(); ++k) {
    if (k == cut) variances.interrupt();
    variances.add(y[k]);
  }
  const auto points = variances.points();
  REQUIRE(points.size() > 15);
  for (const Point& point : points) {
    const auto m = static_cast<std::size_t>(std::llround(point.tau / interval));
    std::size_t stride = 1;
    while (m > 64 && 32 * stride <= m && m % (2 * stride) == 0) stride *= 2;
    CHECK(16 * stride <= std::max<std::size_t>(m, 16));
    long double sum = 0;
    std::int64_t count = 0;
    for (const auto& [from, to] : {std::pair<std::size_t, std::size_t>(0, cut), std::pair(cut, y.size())})
      for (std::size_t k = from; k + 2 * m <= to; k += stride) {
        long double first = 0, second = 0;
        for (std::size_t i = 0; i < m; ++i) first += y[k + i], second += y[k + m + i];
        sum += std::pow((second - first) / static_cast<long double>(m), 2) / 2;
        ++count;
      }
    CAPTURE(m, stride);
    CHECK(point.count == count);
    CHECK(std::abs(point.variance - static_cast<double>(sum / count)) < 1e-9 * point.variance);
  }
}

TEST_CASE("the bands of known noises hold the truth, and are as narrow as the record allows") {
  struct Known {
    const char* name;
    double Q, N, B, K;
    std::size_t count;
  };
  const std::vector<Known> cases = {{"white", 0, 0.02, 0, 0, 200'000},
                                    {"white and random walk", 0, 0.02, 0, 0.004, 200'000},
                                    {"white, flicker and random walk", 0, 0.01, 0.01, 0.002, 500'000},
                                    {"quantization and white", 0.002, 0.02, 0, 0, 200'000}};
  constexpr int seeds = 30;
  for (const Known& known : cases) {
    const std::map<Term, double> truth = {{Term::quantization, known.Q},
                                          {Term::white, known.N},
                                          {Term::flicker, known.B},
                                          {Term::random_walk, known.K}};
    std::map<Term, int> shown, covered;
    std::map<Term, double> width, scatter;
    int wrong = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      auto y = white(known.count, known.N, random);
      if (known.K > 0) add_random_walk(y, known.K, random);
      if (known.B > 0) add_flicker(y, known.B, random);
      if (known.Q > 0) add_quantization(y, known.Q, random);
      for (const auto& estimate : fit_of(y).estimates) {
        const auto found = truth.find(estimate.term);
        if (found == truth.end() || found->second == 0) {
          ++wrong;
          continue;
        }
        ++shown[estimate.term];
        covered[estimate.term] += estimate.low <= found->second && found->second <= estimate.high;
        width[estimate.term] += std::log(estimate.high / estimate.low) / 2 / 1.96 / seeds;
        scatter[estimate.term] += std::pow(std::log(estimate.value / found->second), 2) / seeds;
        if (estimate.term == Term::white && known.B == 0) CHECK(std::abs(estimate.value / found->second - 1) < 0.05);
      }
    }
    std::printf("%s: terms that are not there: %d of %d\n", known.name, wrong, seeds);
    for (const auto& [term, coefficient] : truth) {
      if (coefficient == 0) continue;
      const double relative = std::sqrt(scatter[term]);
      std::printf("  %-12s shown %d, in the band %d of %d, 1-sigma %.4f, scatter %.4f\n", term_name(term), shown[term],
                  covered[term], seeds, width[term], relative);
      CAPTURE(known.name, term_name(term));
      CHECK(shown[term] == seeds);
      CHECK(covered[term] >= 26);
      CHECK(width[term] < 1.5 * relative);
    }
    CHECK(wrong <= 2);
  }
}

}  // namespace allan_test
