// SPDX-License-Identifier: Apache-2.0
// The units in which a page shows what is SI inside.
#pragma once

#include <span>
#include <string>

namespace binnacle::report {

struct Display {
  std::string unit;  // "" of a pure number
  double scale = 1;  // shown = SI / scale
};

/// `wished`, where it is another unit than the SI one. Else angles in degrees and angular rates in deg/s, or deg/h where
/// all are slower than 360 deg/h.
Display display_of(const std::string& si_unit, const std::string& wished, std::span<const double> values);

}  // namespace binnacle::report
