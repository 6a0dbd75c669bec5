// SPDX-License-Identifier: Apache-2.0
#include "chi_squared/chi_squared.hpp"

#include <boost/math/special_functions/gamma.hpp>

namespace binnacle {

double chi_squared_quantile(double dof, double p) { return 2 * boost::math::gamma_p_inv(dof / 2, p); }

std::pair<double, double> chi_squared_band(double dof, double n, double probability) {
  const double shape = dof * n / 2, tail = (1 - probability) / 2;
  return {2 * boost::math::gamma_p_inv(shape, tail) / n, 2 * boost::math::gamma_q_inv(shape, tail) / n};
}

}  // namespace binnacle
