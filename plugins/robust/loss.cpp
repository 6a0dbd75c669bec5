// SPDX-License-Identifier: Apache-2.0
#include "loss.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace binnacle::robust {

double weight(Loss loss, double tuning, int m, double squared) noexcept {
  switch (loss) {
    case Loss::huber: return squared <= tuning * tuning ? 1.0 : tuning / std::sqrt(squared);
    case Loss::cauchy: return 1.0 / (1.0 + squared / (tuning * tuning));
    case Loss::student_t: return (tuning + m) / (tuning + squared);
    case Loss::dcs: break;
  }
  const double s = 2.0 * tuning / (tuning + squared);
  return s >= 1.0 ? 1.0 : s * s;
}

double settled_weight(Loss loss, Whitened of, double tuning, int m, double squared) noexcept {
  if (of == Whitened::residual) return weight(loss, tuning, m, squared);
  // The positive zero of a w² + b w − c.
  const auto zero = [](double a, double b, double c) { return 2.0 * c / (b + std::sqrt(b * b + 4.0 * a * c)); };
  switch (loss) {
    case Loss::huber: return squared <= tuning * tuning ? 1.0 : std::cbrt(tuning * tuning / squared);
    case Loss::cauchy: return zero(squared / (tuning * tuning), 1.0, 1.0);
    case Loss::student_t: return zero(squared, tuning, tuning + m);
    case Loss::dcs: break;
  }
  // s³ + p s − 2 p = 0 with p = Φ/d² (Cardano, with one real zero).
  const double p = tuning / squared;
  const double s = p >= 1.0 ? 1.0 : 2.0 * std::sqrt(p / 3.0) * std::sinh(std::asinh(3.0 * std::sqrt(3.0 / p)) / 3.0);
  return s * s;
}

double efficiency(Loss loss, Whitened of, double tuning, int m) {
  // d of m rows lies about √m with a deviation of less than 1. By the midpoint rule.
  constexpr int intervals = 1000;
  constexpr double beyond = 11.0;
  const double root = std::sqrt(static_cast<double>(m)), first = std::max(0.0, root - beyond);
  const double step = (root + beyond - first) / intervals;
  const double log_scale = (0.5 * m - 1.0) * std::numbers::ln2 + std::lgamma(0.5 * m);
  double lost = 0.0;
  for (int i = 0; i < intervals; ++i) {
    const double d = first + (i + 0.5) * step;
    const double density = std::exp((m - 1) * std::log(d) - 0.5 * d * d - log_scale);
    const double missing = (1.0 - settled_weight(loss, of, tuning, m, d * d)) * d;
    lost += missing * missing * density * step;
  }
  return 1.0 - lost / m;
}

double tuning_of(Loss loss, Whitened of, double wanted, int m) {
  double low = loss == Loss::student_t ? 1.0 : 1e-3, high = 1e5;
  if (efficiency(loss, of, low, m) >= wanted) return low;
  for (int i = 0; i < 50; ++i) {
    const double middle = std::sqrt(low * high);
    (efficiency(loss, of, middle, m) < wanted ? low : high) = middle;
  }
  return high;
}

}  // namespace binnacle::robust
