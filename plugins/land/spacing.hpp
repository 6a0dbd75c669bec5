// SPDX-License-Identifier: Apache-2.0
// Spacing: the least time between two accepted samples, for models that listen to a fast channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "binnacle/binding.hpp"
#include "binnacle/result.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle::land {

/// Its memory is the time of the last accepted sample: what a model writes is kept only when its sample is accepted.
class Spacing {
 public:
  static ParameterSpec parameter() {
    return parameter::time("spacing").at_least(0).defaults("0").about(
        "samples nearer than this to the last accepted one are unsupported");
  }

  explicit Spacing(const Binding& binding) : spacing_(binding.parameters().time("spacing")) {}

  std::size_t memory_bytes() const { return spacing_ > 0 ? sizeof(Time) : 0; }
  void start(std::byte* memory) const {
    if (spacing_ > 0) std::memcpy(memory, &no_time, sizeof(Time));
  }
  /// Whether a sample at t comes late enough; notes it then.
  Result pass(Time t, std::byte* memory) const {
    if (spacing_ == 0) return Result::ok();
    Time last = no_time;
    std::memcpy(&last, memory, sizeof(Time));
    const auto age = static_cast<std::uint64_t>(t) - static_cast<std::uint64_t>(last);
    if (last != no_time && t >= last && age < static_cast<std::uint64_t>(spacing_))
      return Result::unsupported("the last accepted sample is nearer than 'spacing'");
    std::memcpy(memory, &t, sizeof(Time));
    return Result::ok();
  }

 private:
  Time spacing_;
};

}  // namespace binnacle::land
