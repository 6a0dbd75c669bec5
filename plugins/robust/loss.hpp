// SPDX-License-Identifier: Apache-2.0
// Robust losses: the weight that each gives a whitened residual, and how efficient it is where there are no outliers.
#pragma once

namespace binnacle::robust {

enum class Loss { huber, cauchy, student_t, dcs };

/// w(d) = ρ'(d)/d of a block of m rows whose whitened residual has the norm d. `squared`: d²; `tuning`: the loss's own
/// constant, k, c, ν or Φ. README.md has ρ and the sources.
///     huber      1 for d ≤ k, else k/d
///     cauchy     1/(1 + d²/c²)
///     student_t  (ν + m)/(ν + d²)
///     dcs        s², s = min(1, 2Φ/(Φ + d²))
/// Each falls as d² grows, but no faster than 1/d⁴: −2 ≤ d ln w / d ln d² ≤ 0.
double weight(Loss loss, double tuning, int m, double squared) noexcept;

/// The residual d that is whitened: that of an update, by R; or the innovation by HPHᵀ + R/w, with the weight in it.
enum class Whitened { residual, innovation };

/// The weight of a block whose prior is known so well that its innovation is its noise: with rᵀ R⁻¹ r = `squared`, the
/// weight itself of the residual, and w = W(w · squared) of the innovation.
double settled_weight(Loss loss, Whitened of, double tuning, int m, double squared) noexcept;

/// Of what an update of such a state gains from a block of m rows of Gaussian noise, the share that is left with the
/// weights. With the gain K w instead of K the error x − w K r has, since E[x | r] = K r, the covariance
///     P⁻ − K E[(2 w − w²) r rᵀ] Kᵀ   instead of   P⁻ − K S Kᵀ ,
/// which is the share
///     1 − E[(1 − w)² d²] / m ,   d² ~ χ² of m degrees of freedom.
double efficiency(Loss loss, Whitened of, double tuning, int m);

/// The constant with which a block of m rows has this efficiency; of student_t at least 1.
double tuning_of(Loss loss, Whitened of, double efficiency, int m);

}  // namespace binnacle::robust
