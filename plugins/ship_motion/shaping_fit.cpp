// SPDX-License-Identifier: Apache-2.0
#include "shaping_fit.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "binnacle/eigen.hpp"
#include "binnacle/parameters.hpp"

namespace binnacle::ship_motion {

namespace {

using Cost = std::function<double(const Eigen::VectorXd&)>;

struct Vertex {
  Eigen::VectorXd x;
  double cost;
};

/// J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7(4), 1965.
Vertex descended(const Cost& cost, const Eigen::VectorXd& from) {
  const Eigen::Index n = from.size();
  const auto at = [&](Eigen::VectorXd x) {
    const double c = cost(x);
    return Vertex{std::move(x), c};
  };
  std::vector<Vertex> simplex{at(from)};
  for (Eigen::Index i = 0; i < n; ++i) simplex.push_back(at(from + 0.2 * Eigen::VectorXd::Unit(n, i)));
  for (int step = 0; step < 1000; ++step) {
    std::sort(simplex.begin(), simplex.end(), [](const Vertex& a, const Vertex& b) { return a.cost < b.cost; });
    Vertex& worst = simplex.back();
    const Vertex& best = simplex.front();
    if (worst.cost - best.cost <= 1e-10 * std::abs(best.cost) && (worst.x - best.x).norm() < 1e-6) break;
    Eigen::VectorXd centre = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) centre += simplex[static_cast<std::size_t>(i)].x / static_cast<double>(n);
    const Eigen::VectorXd away = centre - worst.x;
    Vertex reflected = at(centre + away);
    if (reflected.cost < best.cost) {
      Vertex further = at(centre + 2 * away);
      worst = further.cost < reflected.cost ? std::move(further) : std::move(reflected);
    } else if (reflected.cost < simplex[static_cast<std::size_t>(n - 1)].cost) {
      worst = std::move(reflected);
    } else if (Vertex nearer = at(centre + (reflected.cost < worst.cost ? 0.5 : -0.5) * away);
               nearer.cost < std::min(worst.cost, reflected.cost)) {
      worst = std::move(nearer);
    } else {
      for (std::size_t i = 1; i < simplex.size(); ++i) simplex[i] = at(0.5 * (simplex[i].x + best.x));
    }
  }
  return *std::min_element(simplex.begin(), simplex.end(),
                           [](const Vertex& a, const Vertex& b) { return a.cost < b.cost; });
}

/// Logarithms of the frequencies, then of the damping ratios.
ShapingFilter filter_of(const Eigen::VectorXd& x, double sigma) {
  const Eigen::Index n = x.size() / 2;
  return {x.head(n).array().exp(), x.tail(n).array().exp(), sigma};
}

/// Beyond, nothing is learnt from the data any more: a spike, or no resonance.
bool is_sensible(const ShapingFilter& filter, double last) {
  return filter.zeta.minCoeff() > 1e-3 && filter.zeta.maxCoeff() < 3 && filter.omega.maxCoeff() < 2 * last;
}

double distance_about_peak(const Spectrum& given) {
  Eigen::Index at = 0;
  given.density.maxCoeff(&at);
  const Eigen::Index low = std::max<Eigen::Index>(at - 1, 0), high = std::min(at + 1, given.omega.size() - 1);
  return (given.omega[high] - given.omega[low]) / static_cast<double>(high - low);
}

/// `seen`: the densities of a model at the given frequencies.
ShapingFit fit_seen(int order, const Spectrum& given, double variance,
                    const std::function<Eigen::VectorXd(const ShapingFilter&)>& seen) {
  const double sigma = std::sqrt(variance), last = given.omega[given.omega.size() - 1];
  const double power = (given.density.array().square() * given.width.array()).sum();
  if (!std::isnormal(power) || !std::isnormal(variance) || !std::isfinite(given.moment(1)))
    throw ComponentError("the motion to be fitted is too small or too large: its power is out of range", "/fit");
  const Cost cost = [&](const Eigen::VectorXd& x) {
    const ShapingFilter filter = filter_of(x, sigma);
    if (!is_sensible(filter, last)) return 1e6;
    return ((given.density - seen(filter)).array().square() * given.width.array()).sum() / power;
  };
  // A peak may be a spike on a flat top, and the second frequency lie on either side: several beginnings.
  const double centre = given.moment(1) / given.moment(0);
  Vertex best{{}, std::numeric_limits<double>::infinity()};
  for (const double first : {given.peak() > 0 ? given.peak() : 0.5 * centre, centre})
    for (const double ratio : order == 2 ? std::vector<double>{1} : std::vector<double>{0.7, 1, 1.5, 3})
      for (const double zeta : {0.05, 0.3}) {
        Eigen::VectorXd start(order);
        if (order == 2)
          start << std::log(first), std::log(zeta);
        else
          start << std::log(first), std::log(ratio * first), std::log(zeta), std::log(zeta);
        Vertex found = descended(cost, start);
        if (found.cost < best.cost) best = std::move(found);
      }
  if (!std::isfinite(best.cost)) throw ComponentError("the fit failed: no initial value has a finite misfit", "/fit");
  best = descended(cost, best.x);

  ShapingFit result;
  result.filter = filter_of(best.x, sigma);
  // The two are alike: the sharper one, whose states are the motion's own, comes first.
  if (order == 4 && result.filter.omega[0] > result.filter.omega[1]) {
    result.filter.omega.reverseInPlace();
    result.filter.zeta.reverseInPlace();
  }
  const Eigen::VectorXd model = seen(result.filter);
  result.given_significant = 2 * sigma;
  result.model_significant = 2 * std::sqrt(model.dot(given.width));
  result.given_peak = given.peak();
  result.model_peak = result.filter.peak();
  result.resolution = distance_about_peak(given);
  result.misfit = 0.5 * (given.density - model).cwiseAbs().dot(given.width) / given.moment(0);
  return result;
}

}  // namespace

bool ShapingFit::is_good() const {
  return std::abs(model_significant / given_significant - 1) < 0.15 &&
         std::abs(model_peak - given_peak) <= std::max(resolution, 0.1 * given_peak) && misfit < 0.25;
}

ShapingFit fit(int order, const Spectrum& given) {
  return fit_seen(order, given, given.moment(0),
                  [&](const ShapingFilter& filter) { return filter.spectrum(given.omega); });
}

ShapingFit fit(int order, const Eigen::VectorXd& series, const Welch& welch) {
  const double variance = series.squaredNorm() / static_cast<double>(series.size());
  return fit_seen(order, welch.of(series), variance, [&](const ShapingFilter& filter) {
    return welch.expected(filter.autocovariance(welch.interval(), welch.length()));
  });
}

}  // namespace binnacle::ship_motion
