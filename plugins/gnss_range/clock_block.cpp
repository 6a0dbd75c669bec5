// SPDX-License-Identifier: Apache-2.0
// The receiver's clock.
#include "clock_block.hpp"

namespace binnacle::gnss_range {

ComponentSpec ClockBlock::spec() {
  ComponentSpec spec;
  spec.type = "receiver_clock";
  spec.summary = "Bias and drift of a receiver's clock, in metres and metres per second.";
  spec.source = "paper 003, equation (4)";
  spec.kind = "receiver_clock";
  spec.example = R"json({"init": {"bias": 0, "drift": 0}, "sigma": ["300 km", "1000 m/s"]})json";
  return spec;
}

ClockBlock::ClockBlock(const Binding& /*binding*/) {
  declaration_.kind = "receiver_clock";
  declaration_.stored_size = 2;
  declaration_.error = {{"bias", "m"}, {"drift", "m/s"}};
  declaration_.outputs = {{"bias", "m", "", false, false, "how far the clock is ahead, times c"},
                          {"drift", "m/s", "", false, false, "its rate, times c"}};
}

}  // namespace binnacle::gnss_range
