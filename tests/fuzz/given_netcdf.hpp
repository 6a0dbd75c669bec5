// SPDX-License-Identifier: Apache-2.0
// A NetCDF library that says of a file what it was handed: names, types, shapes and values in any disagreement, of which a real
// file is one in many thousand. HDF5 itself is not tried: it is not ours, and a damaged file brings it down.
//   {"attributes": {"filter": "f", "seed": 1, "is_angle": [0, 1]}, "dimensions": {"time": 3},
//    "variables": {"time": {"type": "double", "dimensions": ["time"], "attributes": {}, "values": [0, 1, 2]}}, "groups": {}}
#pragma once

#include <string_view>

namespace binnacle::fuzz {

/// What the next file that is opened holds; false: it is no JSON object.
bool give_netcdf(std::string_view json);

}  // namespace binnacle::fuzz
