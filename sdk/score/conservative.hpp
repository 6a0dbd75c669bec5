// SPDX-License-Identifier: Apache-2.0
// Measurements whose innovations are far smaller than R and P say. They take accuracy from an estimate and claim none, so
// they are a note beside the verdict.
#pragma once

#include <string>

#include "binnacle/session.hpp"

namespace binnacle::score {

/// What part of its rows' variance a right filter shows where a gate takes the largest away: of single rows, which lose
/// most. 1 without a gate (probability 0).
double share_inside_gate(double probability);

enum class Likely : unsigned char { nothing, sigma, process_noise, persisting_errors };

/// "sigma", …; what a summary has.
const char* likely_name(Likely likely);

/// What is likely, and a sentence with the figures.
struct Conservative {
  Likely likely = Likely::nothing;
  std::string text;
};

/// Of one measurement; nothing: it is not conservative, or not tested. Measurements of considered components, and what
/// "trust" excepts, are not.
Conservative conservative(const FilterInfo& filter, const MeasurementInfo& measurement,
                          const MeasurementCounts& counts);

}  // namespace binnacle::score
