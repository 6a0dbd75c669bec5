// SPDX-License-Identifier: Apache-2.0
// SplineNoise: a smooth random function of time that is known at any instant without running up to it.
#pragma once

#include <cstdint>
#include <string_view>

#include "random/philox.hpp"

namespace binnacle::vehicle_simulator {

/// Its coefficients around an instant, kept because the next question is about an instant near by; plain memory.
struct SplineMemory {
  random::Philox stream;  // at its beginning
  std::int64_t knot;      // to which the coefficients belong
  double coefficient[6];
};

/// D(t) = a Σ c_k B(t/h − k), B the quintic B-spline and c_k ~ N(0, 1) drawn by their number k: Gaussian, four times
/// differentiable. a makes the standard deviation of D′ one. D′ has no mean, its density is greatest at 0.2214/h, and
/// values of it that lie 6h apart are independent: at that spacing it is white noise to the letter.
class SplineNoise {
 public:
  struct Value {
    double value, first, second;  // D, D′, D″
  };

  /// frequency: where D′ is strongest, Hz.
  explicit SplineNoise(double frequency);

  static SplineMemory start(std::uint64_t seed, std::string_view name);
  /// At t [s]; the memory makes no difference to the answer.
  Value at(double t, SplineMemory& memory) const;

 private:
  double spacing_;  // s, h
  double scale_;    // s, a
};

}  // namespace binnacle::vehicle_simulator
