// SPDX-License-Identifier: Apache-2.0
// The samples that one update of the attitude takes.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

#include "attitude/rotation_vector.hpp"
#include "binnacle/process_model.hpp"
#include "inertial/sample_memory.hpp"
#include "strapdown/mechanization.hpp"

namespace binnacle::inertial {

class SampleGroup {
 public:
  /// What no inertial sensor says of one sample; beyond, the series of the mechanization overflow.
  static constexpr const char* implausible =
      "a sample of more than 1000 s, 1000 rad or 100 km/s is no inertial sensor's";

  /// Takes up to `most` whole samples from the front of `rest`, or one fragment; what has no length is passed over. Samples
  /// of less than half or more than twice the first one's length begin a group of their own: a polynomial through lengths as
  /// unequal as 1:1:30:1 has weights in the hundreds. False: a sample is implausible.
  bool take(std::span<const InputSample>& rest, int most, const SensorFields& fields) {
    while (!rest.empty() && count_ < static_cast<std::size_t>(most)) {
      const InputSample& sample = rest.front();
      if (sample.is_fragment() && count_ > 0) return true;
      if (count_ > 0 && sample.dt > 0.0 && !is_alike(sample.dt, measured(0).dt)) return true;
      rest = rest.subspan(1);
      if (!(sample.dt > 0.0)) continue;
      std::construct_at(&measured_.of[count_], SampleMemory::increment(sample, fields));
      if (!is_plausible(measured(count_))) return false;
      samples_[count_++] = &sample;
      if (sample.is_fragment()) return true;
    }
    return true;
  }

  std::size_t count() const { return count_; }
  const InputSample& sample(std::size_t i) const { return *samples_[i]; }
  const strapdown::Increment& measured(std::size_t i) const { return measured_.of[i]; }
  strapdown::Increment sum() const {
    strapdown::Increment all = measured(0);
    for (std::size_t i = 1; i < count_; ++i)
      all.dt += measured(i).dt, all.dtheta += measured(i).dtheta, all.dv += measured(i).dv;
    return all;
  }

 private:
  static bool is_alike(double a, double b) { return a <= 2.0 * b && b <= 2.0 * a; }
  static bool is_plausible(const strapdown::Increment& measured) {
    constexpr double longest = 1e3, largest_turn = 1e3, largest_velocity = 1e5;  // s, rad, m/s
    return measured.dt <= longest && measured.dtheta.squaredNorm() <= largest_turn * largest_turn &&
           measured.dv.squaredNorm() <= largest_velocity * largest_velocity;
  }

  /// Not made before they are needed: most groups are of one sample.
  union Increments {
    Increments() {}
    std::array<strapdown::Increment, attitude::most_samples> of;
  };
  static_assert(std::is_trivially_destructible_v<strapdown::Increment>);

  std::array<const InputSample*, attitude::most_samples> samples_;
  Increments measured_;
  std::size_t count_ = 0;
};

}  // namespace binnacle::inertial
