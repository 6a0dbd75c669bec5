// SPDX-License-Identifier: Apache-2.0
// The open-circuit voltage of a cell over its state of charge: a curve through given points, rising with them.
#pragma once

#include <binnacle/plugin.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

/// Piecewise cubic through the points, monotone between them, with a continuous derivative: F. N. Fritsch, R. E.
/// Carlson, "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal. 17(2), 1980, pp. 238-246; slopes by the
/// harmonic mean of F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984. Beyond the first and the last
/// point it goes on as a straight line.
class OcvCurve {
 public:
  struct Value {
    double volts;  // OCV(s) [V]
    double slope;  // dOCV/ds [V]
  };

  /// soc [1]: at least two, rising; volts [V]: as many, rising. Anything else is a ComponentError.
  OcvCurve(const Eigen::Ref<const Eigen::VectorXd>& soc, const Eigen::Ref<const Eigen::VectorXd>& volts)
      : soc_(soc.begin(), soc.end()), volts_(volts.begin(), volts.end()) {
    if (soc_.size() < 2) throw binnacle::ComponentError("a curve has two points at least", "/ocv_soc");
    if (volts_.size() != soc_.size()) throw binnacle::ComponentError("not as many as in 'ocv_soc'", "/ocv");
    for (std::size_t i = 1; i < soc_.size(); ++i) {
      if (!(soc_[i] > soc_[i - 1])) throw binnacle::ComponentError("each must be above the one before", "/ocv_soc");
      if (!(volts_[i] > volts_[i - 1])) throw binnacle::ComponentError("each must be above the one before", "/ocv");
    }
    slopes_ = slopes();
  }

  Value at(double soc) const {
    if (soc <= soc_.front()) return {volts_.front() + slopes_.front() * (soc - soc_.front()), slopes_.front()};
    if (soc >= soc_.back()) return {volts_.back() + slopes_.back() * (soc - soc_.back()), slopes_.back()};
    const auto above = std::upper_bound(soc_.begin(), soc_.end(), soc);
    const auto i = static_cast<std::size_t>(above - soc_.begin()) - 1;
    const double h = soc_[i + 1] - soc_[i], u = (soc - soc_[i]) / h;
    const double rise = (volts_[i + 1] - volts_[i]) / h;
    // Hermite's cubic, in powers of u = (s − s_i)/h.
    const double c2 = 3 * rise - 2 * slopes_[i] - slopes_[i + 1], c3 = slopes_[i] + slopes_[i + 1] - 2 * rise;
    return {volts_[i] + h * u * (slopes_[i] + u * (c2 + u * c3)), slopes_[i] + u * (2 * c2 + 3 * c3 * u)};
  }

 private:
  double rise(std::size_t i) const { return (volts_[i + 1] - volts_[i]) / (soc_[i + 1] - soc_[i]); }

  /// At every point; each at most three times the rise of the intervals beside it, which keeps the cubic monotone.
  std::vector<double> slopes() const {
    const std::size_t last = soc_.size() - 1;
    std::vector<double> m(soc_.size());
    m[0] = rise(0), m[last] = rise(last - 1);
    for (std::size_t i = 1; i < last; ++i) {
      const double before = soc_[i] - soc_[i - 1], after = soc_[i + 1] - soc_[i];
      const double w1 = 2 * after + before, w2 = after + 2 * before;
      m[i] = (w1 + w2) / (w1 / rise(i - 1) + w2 / rise(i));
    }
    return m;
  }

  std::vector<double> soc_, volts_, slopes_;
};

namespace ocv_curve {

/// The two parameters of a curve, for the components that have one.
inline std::vector<binnacle::ParameterSpec> parameters() {
  using namespace binnacle::parameter;
  std::vector<binnacle::ParameterSpec> specs;
  specs.push_back(vector("ocv_soc", "1").at_least(0).at_most(1).required().about("states of charge, rising"));
  specs.push_back(vector("ocv", "V").required().about("open-circuit voltage at each of them, rising"));
  return specs;
}

inline OcvCurve of(const binnacle::Parameters& parameters) {
  return {parameters.vector("ocv_soc"), parameters.vector("ocv")};
}

}  // namespace ocv_curve
