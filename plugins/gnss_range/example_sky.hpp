// SPDX-License-Identifier: Apache-2.0
// A made-up sky for the examples of the range models: what the conformance suite gives them besides the state.
#pragma once

namespace binnacle::gnss_range {

/// Six GPS satellites on circular orbits, 27 to 68 deg above the horizon at 37.4 deg N, 126.9 deg E two seconds after toe.
inline constexpr const char* example_sky = R"json({
  "time": 2,
  "sample": {"satellite": [101, 104, 107, 110, 113, 116],
    "pseudorange": [20552027, 21877534, 22149575, 22534000, 21246293, 23058576],
    "range_rate": 0},
  "inputs": {
    "iono": {"a0": 1.1e-8, "a1": 7e-9, "a2": -6e-8, "a3": -6e-8, "b0": 9e4, "b1": 1.6e4, "b2": -1.9e5, "b3": -6e4},
    "ephemeris": {"satellite": [101, 104, 107, 110, 113, 116],
      "toe": 0, "toc": 0, "semi_major_axis": 26560e3, "eccentricity": 0, "i0": 0.96, "perigee": 0,
      "omega0": [1.0178, 0.6588, 2.6386, -1.2941, 1.3245, -1.5538],
      "m0": [1.4021, 2.1503, 0.1070, 3.2472, 0.5475, 2.4159],
      "delta_n": 0, "omega_dot": 0, "i_dot": 0, "cuc": 0, "cus": 0, "crc": 0, "crs": 0, "cic": 0, "cis": 0,
      "af0": 1e-5, "af1": 0, "af2": 0, "group_delay": 0, "accuracy": 2, "issue": 7}}})json";

}  // namespace binnacle::gnss_range
