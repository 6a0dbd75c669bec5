// SPDX-License-Identifier: Apache-2.0
// Jacobians without a pencil: H, Φ or J of a first correct model, from dual numbers or from differences. Header-only.
//
// Write the prediction as a function of the error δ of a port, once, for any scalar:
//
//     const Eigen::Vector2d x = in.x[position_].as<2>();
//     const auto range = [&](const auto& delta) { return jacobian::column((x + delta - beacon_).norm()); };
//     out.residual[0] = in.sample[range_] - range(Eigen::Vector2d::Zero().eval())[0];
//     if (auto H = out.H[position_]) H.as<1, 2>() = jacobian::by_duals<1, 2>(range);
//
// A port on a manifold takes its ⊞ into the function: q(δ) = exp(δ) ⊗ q̂. Say in the declaration what is used
// (`declaration_.differentiated_by(Differentiation::dual_numbers)`): `binnacle explain` shows it.
#pragma once

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include "binnacle/declaration.hpp"

namespace binnacle::jacobian {

/// A number with its derivatives by `Dof` error components.
template <int Dof>
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, Dof, 1>>;

/// A scalar expression as the one row of a function's value: double, or Dual for an argument of Duals.
inline Eigen::Matrix<double, 1, 1> column(double value) { return Eigen::Matrix<double, 1, 1>(value); }
template <class Derivatives>
auto column(const Eigen::AutoDiffScalar<Derivatives>& value) {
  using Scalar = Eigen::AutoDiffScalar<typename Eigen::internal::remove_all<Derivatives>::type::PlainObject>;
  Eigen::Matrix<Scalar, 1, 1> one;
  one[0] = Scalar(value.value(), value.derivatives());
  return one;
}

/// ∂f/∂δ at δ = 0, exact to roundoff. f: Matrix<Dual<Dof>, Dof, 1> → Matrix<Dual<Dof>, Rows, 1>; nothing is allocated.
/// Where f branches on a value, the derivative is that of the branch taken; at |v| = 0 a norm has none.
template <int Rows, int Dof, class Function>
Eigen::Matrix<double, Rows, Dof> by_duals(const Function& f) {
  Eigen::Matrix<Dual<Dof>, Dof, 1> delta;
  for (int i = 0; i < Dof; ++i) delta[i] = Dual<Dof>(0.0, Dof, i);
  const Eigen::Matrix<Dual<Dof>, Rows, 1> value = f(delta);
  Eigen::Matrix<double, Rows, Dof> J;
  for (int i = 0; i < Rows; ++i) J.row(i) = value[i].derivatives().transpose();
  return J;
}

/// ∂f/∂δ at δ = 0 by central differences at `step` and at half of it (Richardson), so that the error is of the fourth
/// power of the step. f: Vector<double, Dof> → Vector<double, Rows>, already as a difference where the value is on a
/// manifold. step: per component, of the size of a plausible error.
template <int Rows, int Dof, class Function>
Eigen::Matrix<double, Rows, Dof> by_differences(const Function& f, const Eigen::Matrix<double, Dof, 1>& step) {
  Eigen::Matrix<double, Rows, Dof> J;
  for (int j = 0; j < Dof; ++j) {
    const auto central = [&](double h) -> Eigen::Matrix<double, Rows, 1> {
      const Eigen::Matrix<double, Dof, 1> delta = h * Eigen::Matrix<double, Dof, 1>::Unit(j);
      const Eigen::Matrix<double, Dof, 1> minus = -delta;
      return (f(delta) - f(minus)) / (2.0 * h);
    };
    J.col(j) = (4.0 * central(0.5 * step[j]) - central(step[j])) / 3.0;
  }
  return J;
}

}  // namespace binnacle::jacobian
