// SPDX-License-Identifier: Apache-2.0
// The likely cause of a doubt, where the data alone show it: a clock, axes, signs, scales.
#pragma once

#include <memory>
#include <vector>

#include "binnacle/diagnostic.hpp"
#include "binnacle/sample.hpp"
#include "field_fit.hpp"
#include "input_fit.hpp"
#include "motion_fields.hpp"

namespace binnacle::score {

/// Watches the channels of one filter. Allocates nothing while it does.
class CauseWatch {
 public:
  explicit CauseWatch(const MotionFields& fields);

  void sampled(int channel, const SampleView& sample);
  void exchange(StateBytes& bytes) {
    for (Fix& fix : fixes_) {
      fix.field_fit.exchange(bytes);
      if (fix.input_fit) fix.input_fit->exchange(bytes);
    }
    bytes.value(input_t_);
  }
  /// B119 a clock, B120 axes, signs and scales.
  Diagnostics causes() const;

 private:
  struct Fix {
    const FixFields* fields;
    FieldFit field_fit;
    std::unique_ptr<InputFit> input_fit;  // null without an inertial input
  };
  const MotionFields& fields_;
  std::vector<Fix> fixes_;
  Time input_t_ = no_time;  // of the newest sample of the input
};

}  // namespace binnacle::score
