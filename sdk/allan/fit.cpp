// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "allan/allan.hpp"

namespace binnacle::allan {

namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using std::numbers::pi;

constexpr double needed_gain = 9;  // of twice the log-likelihood: three standard deviations
constexpr double two_sided = 1.959963984540054;

/// σ²(τ) of a coefficient of 1 (IEEE 952-1997, C.1).
double shape(Term term, double tau) {
  switch (term) {
    case Term::quantization: return 3 / (tau * tau);
    case Term::white: return 1 / tau;
    case Term::flicker: return 2 * std::numbers::ln2 / pi;
    case Term::random_walk: return tau / 3;
    case Term::ramp: return tau * tau / 2;
  }
  return 0;
}

/// One-sided power spectral density of means over intervals h at the frequency f, of a coefficient of 1.
double density(Term term, double f, double h) {
  switch (term) {
    case Term::quantization: return 8 / h * std::pow(std::sin(pi * f * h), 2);
    case Term::white: return 2;
    case Term::flicker: return 1 / (pi * f);
    case Term::random_walk: return 2 / std::pow(2 * pi * f, 2);
    case Term::ramp: return 0;  // not random
  }
  return 0;
}

/// Of what an estimate of the Allan variance at m intervals h lets through of the density at f.
double response(double f, double m, double h) {
  const double sine = std::sin(pi * f * m * h);
  return 2 * std::pow(sine, 4) / std::pow(m * std::sin(pi * f * h), 2);
}

struct Selection {
  std::vector<int> terms;
  VectorXd squares;  // coefficients, squared
  MatrixXd covariance;
  double chi_square = 0;
};

class Fitter {
 public:
  Fitter(std::vector<Point> points, double interval) : points_(std::move(points)), interval_(interval) {
    const auto n = static_cast<Eigen::Index>(points_.size());
    shapes_.resize(n, term_count);
    measured_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      measured_[i] = point(i).variance;
      for (int k = 0; k < term_count; ++k) shapes_(i, k) = shape(static_cast<Term>(k), point(i).tau);
    }
    // First as if estimates were independent.
    covariance_ = MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      covariance_(i, i) = 2 * std::pow(point(i).variance, 2) * point(i).tau / point(i).seconds + 1e-300;
  }

  /// The likeliest set of terms, each with the covariance that it gives itself, of which each term raises 2 ln L by enough.
  Selection run() {
    Selection best;
    double best_score = 0;
    const MatrixXd first = covariance_;
    MatrixXd best_covariance = first;
    for (unsigned set = 1; set < 1U << term_count; ++set) {
      std::vector<int> terms;
      for (int k = 0; k < term_count; ++k)
        if (set >> k & 1U) terms.push_back(k);
      if (static_cast<Eigen::Index>(terms.size()) >= measured_.size()) continue;
      covariance_ = first;
      const Selection selection = settle(terms);
      if (!(selection.squares.minCoeff() > 0)) continue;
      const double score = minus_two_log_likelihood(selection) + needed_gain * static_cast<double>(terms.size());
      if (!best.terms.empty() && !(score < best_score)) continue;
      best_score = score;
      best = selection;
      best_covariance = covariance_;
    }
    covariance_ = best_covariance;
    return best;
  }
  Selection with(std::vector<int> terms) const { return solve(std::move(terms)); }

 private:
  const Point& point(Eigen::Index i) const { return points_[static_cast<std::size_t>(i)]; }

  Selection solve(std::vector<int> terms) const {
    Selection selection;
    const algebra::Cholesky C(covariance_);
    MatrixXd A(measured_.size(), static_cast<Eigen::Index>(terms.size()));
    for (std::size_t k = 0; k < terms.size(); ++k) A.col(static_cast<Eigen::Index>(k)) = shapes_.col(terms[k]);
    const MatrixXd WA = C.solve_L(A);
    const VectorXd Wy = C.solve_L_vector(measured_);
    // Columns of equal length: τ² and 1/τ² are far apart.
    const VectorXd scale = WA.colwise().norm().cwiseInverse();
    const MatrixXd B = WA * scale.asDiagonal();
    selection.covariance = algebra::PivotedCholesky(B.transpose() * B).solve(MatrixXd::Identity(B.cols(), B.cols()));
    selection.squares = scale.asDiagonal() * (selection.covariance * (B.transpose() * Wy));
    selection.covariance = (scale.asDiagonal() * selection.covariance * scale.asDiagonal()).eval();
    selection.chi_square = (Wy - WA * selection.squares).squaredNorm();
    selection.terms = std::move(terms);
    return selection;
  }

  /// With the covariance that it gives itself.
  Selection settle(const std::vector<int>& terms) {
    Selection selection = solve(terms);
    for (int round = 0; round < 5 && selection.squares.minCoeff() > 0; ++round) {
      update_covariance(selection);
      selection = solve(terms);
    }
    return selection;
  }

  double minus_two_log_likelihood(const Selection& selection) const {
    return selection.chi_square + algebra::Cholesky(covariance_).log_determinant();
  }

  /// Of σ̂² at τ_a and τ_b, where the terms hold: (1/T) ∫ S² A_a A_b df, with T the time that both averaged over.
  void update_covariance(const Selection& selection) {
    if (selection.terms.empty()) return;
    const auto n = measured_.size();
    const double lowest = 0.01 / points_.back().tau, highest = 0.5 / interval_;
    constexpr int per_decade = 120;
    const int count = static_cast<int>(per_decade * std::log10(highest / lowest)) + 1;
    MatrixXd weighted(count, n);
    for (int i = 0; i < count; ++i) {
      const double width = std::log(highest / lowest) / count, f = lowest * std::exp((i + 0.5) * width);
      double S = 0;
      for (std::size_t k = 0; k < selection.terms.size(); ++k)
        S += selection.squares[static_cast<Eigen::Index>(k)] *
             density(static_cast<Term>(selection.terms[k]), f, interval_);
      for (Eigen::Index a = 0; a < n; ++a)
        weighted(i, a) = S * mean_response(f, width, point(a).tau / interval_) * std::sqrt(f * width);
    }
    covariance_ = weighted.transpose() * weighted;
    for (Eigen::Index a = 0; a < n; ++a)
      for (Eigen::Index b = 0; b < n; ++b) covariance_(a, b) /= std::sqrt(point(a).seconds * point(b).seconds);
    covariance_.diagonal() *= 1 + 1e-4;  // neighbours say almost the same, and the integral is not exact
  }

  /// Where the response oscillates faster than the grid, its mean: sin⁴ has 3/8.
  double mean_response(double f, double width, double m) const {
    if (m * interval_ * f * width < 0.2) return response(f, m, interval_);
    return 2 * 0.375 / std::pow(m * std::sin(pi * f * interval_), 2);
  }

  std::vector<Point> points_;
  double interval_;
  MatrixXd shapes_, covariance_;
  VectorXd measured_;
};

/// 95 % of a coefficient from its square: log-normal, so that it stays above zero.
void set_band(Fit::Estimate& estimate, double square, double variance) {
  estimate.value = std::sqrt(square);
  const double relative = two_sided * std::sqrt(variance) / (2 * square);
  estimate.low = estimate.value * std::exp(-relative);
  estimate.high = estimate.value * std::exp(relative);
}

void set_taus(std::vector<Fit::Estimate>& estimates, const std::vector<Point>& points) {
  for (auto& estimate : estimates)
    for (const Point& point : points) {
      const double own = estimate.value * estimate.value * shape(estimate.term, point.tau);
      if (3 * own < variance_at(estimates, point.tau)) continue;
      if (estimate.from_tau == 0) estimate.from_tau = point.tau;
      estimate.to_tau = point.tau;
    }
}

}  // namespace

const char* term_name(Term term) {
  constexpr const char* names[] = {"quantization", "white", "flicker", "random_walk", "ramp"};
  return names[static_cast<int>(term)];
}

double variance_at(const std::vector<Fit::Estimate>& estimates, double tau) {
  double sum = 0;
  for (const auto& estimate : estimates) sum += estimate.value * estimate.value * shape(estimate.term, tau);
  return sum;
}

Fit fit(const std::vector<Point>& points, double interval) {
  Fit result;
  double longest = 0;
  for (const Point& point : points) longest = std::max(longest, point.seconds + 2 * point.tau);
  std::vector<Point> used;
  for (const Point& point : points) {
    // Octaves: between them there is hardly anything new.
    const double octave = std::log2(point.tau / interval);
    if (std::abs(octave - std::round(octave)) < 1e-6 && point.tau <= longest / 6 && point.variance > 0)
      used.push_back(point);
  }
  result.used = static_cast<int>(used.size());
  if (used.size() < 4) return result;
  Fitter fitter(used, interval);
  const Selection best = fitter.run();
  for (std::size_t k = 0; k < best.terms.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    Fit::Estimate& estimate = result.estimates.emplace_back();
    estimate.term = static_cast<Term>(best.terms[k]);
    set_band(estimate, best.squares[i], best.covariance(i, i));
  }
  set_taus(result.estimates, used);
  const double freedom = static_cast<double>(used.size() - best.terms.size());
  result.chi_square = best.chi_square / std::max(1.0, freedom);
  for (int term = 0; term < term_count; ++term) {
    if (std::ranges::find(best.terms, term) != best.terms.end()) continue;
    auto terms = best.terms;
    terms.push_back(term);
    const Selection more = fitter.with(terms);
    const auto last = more.squares.size() - 1;
    result.largest[static_cast<std::size_t>(term)] =
        std::sqrt(std::max(0.0, more.squares[last]) + two_sided * std::sqrt(more.covariance(last, last)));
  }
  return result;
}

}  // namespace binnacle::allan
