// SPDX-License-Identifier: Apache-2.0
// An attitude algorithm as it was chosen, with its weights at hand.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "attitude/interval_weights.hpp"
#include "attitude/quaternion.hpp"
#include "attitude/rotation_vector.hpp"

namespace binnacle::attitude {

enum class Precision { double_, float_ };

/// How an attitude is carried from one step to the next; the values are doubles whatever they are computed in.
struct Update {
  Precision precision = Precision::double_;
  Truncation truncation;

  bool is_plain() const { return precision == Precision::double_ && truncation.is_exact(); }
  Eigen::Vector4d operator()(const Eigen::Vector4d& q, const Eigen::Vector3d& phi) const {
    if (precision == Precision::double_) return updated<double>(q, phi, truncation);
    return updated<float>(q.cast<float>(), phi.cast<float>(), truncation).cast<double>();
  }
  Eigen::Vector4d operator()(const Eigen::Vector3d& frame, const Eigen::Vector4d& q, const Eigen::Vector3d& phi) const {
    if (precision == Precision::double_) return updated<double>(frame, q, phi, truncation);
    return updated<float>(frame.cast<float>(), q.cast<float>(), phi.cast<float>(), truncation).cast<double>();
  }
};

/// Immutable. For 1 … `samples` increments: fewer than `samples` go by the weights for so many.
class Algorithm {
 public:
  struct Choice {
    int samples = 1;
    bool uses_previous = true;  ///< of one sample: the one before it shows how the rates change
    Form form = Form::coning;
    Update update;
  };

  Algorithm() : Algorithm(Choice{}) {}
  explicit Algorithm(const Choice& choice) : choice_(choice) {
    for (std::size_t n = 1; n <= most_samples; ++n) {
      pairs_[n - 1] = pair_weights<double>(static_cast<int>(n), choice.form);
      pairs_float_[n - 1] = pair_weights<float>(static_cast<int>(n), choice.form);
      constexpr std::array<double, most_samples> equal = {1, 1, 1, 1};
      weights_[n - 1] = interval_weights(std::span(equal).first(n));
      weights_[n - 1].pairs = pairs_[n - 1];
    }
  }

  int samples() const { return choice_.samples; }
  bool uses_previous() const { return choice_.uses_previous; }
  const Update& update() const { return choice_.update; }

  /// Those of the form for equal intervals; else those of polynomial rates, whatever the form, in `storage`.
  const IntervalWeights& weights(std::span<const double> lengths, IntervalWeights& storage) const {
    if (are_equal(lengths)) return weights_[lengths.size() - 1];
    return storage = interval_weights(lengths);
  }

  /// φ of two and more increments, computed in the precision chosen.
  Eigen::Vector3d rotation(std::span<const Eigen::Vector3d> theta, const IntervalWeights& weights) const {
    if (choice_.update.precision == Precision::double_) return rotation_vector<double>(theta, weights.pairs);
    std::array<Eigen::Vector3f, most_samples> single;
    for (std::size_t i = 0; i < theta.size(); ++i) single[i] = theta[i].cast<float>();
    return rotation_vector<float>(std::span(single).first(theta.size()), in_float(theta.size(), weights))
        .cast<double>();
  }
  /// φ of one increment over `length`, and of the mean rate ω₀ of its neighbour over `neighbour`: rates on a line.
  Eigen::Vector3d rotation(const Eigen::Vector3d& theta, double length, const Eigen::Vector3d& omega_0,
                           double neighbour) const {
    if (!(neighbour > 0.0)) return theta;
    const double weight = length * length / (6.0 * (length + neighbour));
    if (choice_.update.precision == Precision::double_) return theta + weight * omega_0.cross(theta);
    const Eigen::Vector3f single = theta.cast<float>(), omega = omega_0.cast<float>();
    return (single + static_cast<float>(weight) * omega.cross(single)).cast<double>();
  }

 private:
  PairWeights<float> in_float(std::size_t samples, const IntervalWeights& weights) const {
    if (&weights == &weights_[samples - 1]) return pairs_float_[samples - 1];
    PairWeights<float> single;
    for (int i = 0; i < most_samples; ++i)
      for (int j = 0; j < most_samples; ++j) single.k[i][j] = static_cast<float>(weights.pairs.k[i][j]);
    return single;
  }

  Choice choice_;
  std::array<PairWeights<double>, most_samples> pairs_;
  std::array<PairWeights<float>, most_samples> pairs_float_;
  std::array<IntervalWeights, most_samples> weights_;
};

}  // namespace binnacle::attitude
