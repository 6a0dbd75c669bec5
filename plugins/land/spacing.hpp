// SPDX-License-Identifier: Apache-2.0
// Spacing: the least time between two accepted samples, for models that subscribe to a fast channel.
#pragma once

#include <cstdint>

#include "binnacle/binding.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/result.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle::land {

/// Its memory is the time of the last accepted sample: what a model writes is kept only when its sample is accepted.
class Spacing {
 public:
  static ParameterSpec parameter() {
    return parameter::time("spacing").at_least(0).defaults("0").about(
        "shortest time since the last accepted sample; earlier samples are unsupported");
  }

  Spacing(const Binding& binding, MeasurementDeclaration& declaration)
      : spacing_(binding.parameters().time("spacing")) {
    if (spacing_ > 0) last_ = declaration.keeps<LastAccepted>();
  }

  /// Whether the sample comes late enough; remembers its time then.
  Result pass(const MeasurementInput& in) const {
    if (spacing_ == 0) return Result::ok();
    const Time t = in.sample.t;
    LastAccepted& last = in.memory[last_];
    const auto age = static_cast<std::uint64_t>(t) - static_cast<std::uint64_t>(last.t);
    if (last.t != no_time && t >= last.t && age < static_cast<std::uint64_t>(spacing_))
      return Result::unsupported("the last accepted sample is nearer than 'spacing'");
    last.t = t;
    return Result::ok();
  }

 private:
  struct LastAccepted {
    Time t = no_time;
  };
  Time spacing_;
  Memory<LastAccepted> last_;
};

}  // namespace binnacle::land
