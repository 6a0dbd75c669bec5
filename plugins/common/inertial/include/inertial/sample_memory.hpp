// SPDX-License-Identifier: Apache-2.0
// What an inertial process remembers between steps, as plain bytes for the arena.
#pragma once

#include "binnacle/process_model.hpp"
#include "binnacle/view.hpp"
#include "strapdown/mechanization.hpp"

namespace binnacle::inertial {

/// The increments of a sample. Without accelerometers dv stays as it is made: not bound.
struct SensorFields {
  Fields<3> dtheta;  // rad
  Fields<3> dv;      // m/s
};

/// The neighbours of the sample to come, as measured, and the sample last begun. All zero: nothing is known.
///
/// They are corrected when they are used, by the errors estimated then: a line through the rates of two samples that
/// were corrected differently would show a change of the estimate as a motion.
class SampleMemory {
 public:
  /// The increment of a sample or fragment, with the place of a fragment in its whole sample.
  static strapdown::Increment increment(const InputSample& sample, const SensorFields& fields) {
    strapdown::Increment increment;
    increment.dt = sample.dt;
    increment.dtheta = sample[fields.dtheta];
    if (fields.dv.is_bound()) increment.dv = sample[fields.dv];
    if (sample.is_fragment()) {
      // Labels may differ from the length the numbers belong to (a fixed `interval`): scale by the label's share.
      const double per_label = sample.dt / static_cast<double>(sample.t1 - sample.t0);
      increment.sample_dt = static_cast<double>(sample.whole_t1 - sample.whole_t0) * per_label;
      increment.sample_offset = static_cast<double>(sample.t0 - sample.whole_t0) * per_label;
    }
    return increment;
  }

  /// What preceded the sample; nothing after a gap, where a line through the rates of neighbours means nothing.
  strapdown::Previous before(const InputSample& sample) const {
    const bool continues = sample.whole_t0 == whole_t0_ && sample.whole_t1 == whole_t1_;
    if (!continues && sample.whole_t0 != whole_t1_) return {};
    return {last_.rates(), before_.rates()};
  }

  void remember(const strapdown::Previous& measured, const strapdown::Increment& increment, const InputSample& sample) {
    const strapdown::Previous next = strapdown::remember(measured, increment);
    last_ = Rates(next.last);
    before_ = Rates(next.before);
    whole_t0_ = sample.whole_t0;
    whole_t1_ = sample.whole_t1;
  }

 private:
  struct Rates {
    double dt = 0;         // s; 0: none
    double omega[3] = {};  // rad/s
    double f[3] = {};      // m/s²

    Rates() = default;
    explicit Rates(const strapdown::MeanRates& mean) : dt(mean.dt) {
      vector_at<3>(omega) = mean.omega;
      vector_at<3>(f) = mean.f;
    }
    strapdown::MeanRates rates() const { return {dt, vector_at<3>(omega), vector_at<3>(f)}; }
  };

  Rates last_, before_;
  Time whole_t0_ = 0;  // of the sample begun last
  Time whole_t1_ = 0;
};

}  // namespace binnacle::inertial
