// SPDX-License-Identifier: Apache-2.0
// The rotation vector of an interval, and the velocity gained in it, from 1 to 4 gyro and accelerometer increments.
#pragma once

#include <cstddef>
#include <span>
#include <tuple>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace binnacle::attitude {

template <class Scalar>
using Vector3 = Eigen::Matrix<Scalar, 3, 1>;

inline constexpr int most_samples = 4;

/// `coning`: least error on a coning motion (paper 002, equations 2, 3, 9). `polynomial`: exact to second order where the
/// angular rate is a polynomial of degree N − 1 (Jordan; Miller; for four samples paper 002, equation 4, solved anew).
/// For one and two samples they are the same.
enum class Form { coning, polynomial };

/// k_ij of   φ = Σ θ_i + Σ_{i<j} k_ij θ_i × θ_j   for N increments θ_i of equal length; k[i][j], i < j, from zero.
template <class Scalar>
struct PairWeights {
  Scalar k[most_samples][most_samples] = {};
};

template <class Scalar>
PairWeights<Scalar> pair_weights(int samples, Form form) {
  const auto ratio = [](int numerator, int denominator) { return Scalar(numerator) / Scalar(denominator); };
  PairWeights<Scalar> w;
  auto& k = w.k;
  if (samples == 2) {
    k[0][1] = ratio(2, 3);  // (2)
  } else if (samples == 3 && form == Form::coning) {
    k[0][2] = ratio(9, 20);  // (3): 0.45, 0.675
    k[0][1] = k[1][2] = ratio(27, 40);
  } else if (samples == 3) {
    k[0][2] = ratio(33, 80);
    k[0][1] = k[1][2] = ratio(57, 80);
  } else if (samples == 4 && form == Form::coning) {
    k[0][1] = ratio(-92, 105);  // (9)
    k[0][2] = ratio(92, 105);
    k[0][3] = ratio(54, 105);
    k[1][2] = ratio(306, 105);
  } else if (samples == 4) {
    k[0][1] = k[2][3] = ratio(736, 945);
    k[0][2] = k[1][3] = ratio(334, 945);
    k[0][3] = ratio(526, 945);
    k[1][2] = ratio(654, 945);
  }
  return w;
}

/// φ by the weights.
template <class Scalar>
Vector3<Scalar> rotation_vector(std::span<const Vector3<Scalar>> theta, const PairWeights<Scalar>& weights) {
  Vector3<Scalar> phi = theta[0];
  for (std::size_t j = 1; j < theta.size(); ++j) {
    Vector3<Scalar> before = weights.k[0][j] * theta[0];
    for (std::size_t i = 1; i < j; ++i) before += weights.k[i][j] * theta[i];
    phi += theta[j] + before.cross(theta[j]);
  }
  return phi;
}

/// What changing rates add to ∫ C f dt beyond Σ Δv + ½ Σθ × ΣΔv, by the equivalence of coning and sculling
/// (Roscoe, J. Guidance 24(2), 2001):   Σ_{i<j} k_ij (θ_i × Δv_j + Δv_i × θ_j).
template <class Scalar>
Vector3<Scalar> sculling(std::span<const Vector3<Scalar>> theta, std::span<const Vector3<Scalar>> dv,
                         const PairWeights<Scalar>& weights) {
  Vector3<Scalar> sum = Vector3<Scalar>::Zero();
  for (std::size_t j = 1; j < theta.size(); ++j) {
    Vector3<Scalar> turned = weights.k[0][j] * theta[0], gained = weights.k[0][j] * dv[0];
    for (std::size_t i = 1; i < j; ++i) {
      turned += weights.k[i][j] * theta[i];
      gained += weights.k[i][j] * dv[i];
    }
    sum += turned.cross(dv[j]) + gained.cross(theta[j]);
  }
  return sum;
}

/// Paper 002, equation (5), as printed, with its lost cross taken for θ₂ × θ₄. Not an algorithm: for a rate that changes as
/// (4) says it is off by parts in ten, and on a coning motion it is hardly better than two samples. A counterexample, which a test
/// holds against the true coefficients.
template <class Scalar>
Vector3<Scalar> printed_equation_5(std::span<const Vector3<Scalar>> theta) {
  const auto& [a, b, c, d] = std::tie(theta[0], theta[1], theta[2], theta[3]);
  return a + b + c + d + Scalar(0.7) * a.cross(b) + Scalar(0.146) * a.cross(c) + Scalar(0.23) * a.cross(d) +
         Scalar(1.545) * b.cross(c) + Scalar(1.257) * b.cross(d) - Scalar(0.41) * c.cross(d);
}

}  // namespace binnacle::attitude
