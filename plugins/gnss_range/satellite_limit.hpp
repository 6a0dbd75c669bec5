// SPDX-License-Identifier: Apache-2.0
// How many satellites of an epoch are used: always, and in stretches of time.
#pragma once

#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle::gnss_range {

class SatelliteLimit {
 public:
  static std::vector<ParameterSpec> parameters();
  explicit SatelliteLimit(const Parameters& parameters);

  int most() const noexcept { return most_; }
  int fewest() const noexcept { return fewest_; }
  int at(Time t) const;

 private:
  struct Cut {
    Time from, to;
    int satellites;
  };
  std::vector<Cut> cuts_;
  int most_, fewest_;
};

}  // namespace binnacle::gnss_range
