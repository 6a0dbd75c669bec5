// SPDX-License-Identifier: Apache-2.0
// What variables of a run have in common: units, times, names of components.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "columns.hpp"
#include "netcdf.hpp"
#include "wording/wording.hpp"

namespace binnacle::results {

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

using wording::as_size;

struct Units {
  std::string si, display;
};

inline void put_units(nc::Group group, int variable, const Units& units) {
  if (!units.si.empty()) group.put_text(variable, "units", units.si);
  if (!units.display.empty() && units.display != units.si) group.put_text(variable, "display_units", units.display);
}

inline void put_if_any(nc::Group group, int variable, const char* name, const std::string& text) {
  if (!text.empty()) group.put_text(variable, name, text);
}

inline std::string describe_noise(const std::string& name) {
  return name + ": measurement noise as the noise estimator has it, 1-sigma";
}

/// CF wants "seconds since" an epoch of a time coordinate; which epoch a run's clock counts from is not known.
inline int add_time(nc::Group group, const std::string& name, int dimension, const nc::Storage& storage,
                    const std::string& long_name) {
  const int id = group.add_variable(name, NC_DOUBLE, {dimension}, storage);
  group.put_text(id, "units", "s");
  group.put_text(id, "long_name", long_name);
  group.put_text(id, "axis", "T");
  return id;
}

/// The names of a variable's columns, as a coordinate that has the dimension's own name.
inline int add_components(nc::Group group, const std::string& name, const std::vector<std::string>& components) {
  const int dimension = group.add_dimension(name, components.size());
  group.add_texts(name, {dimension}, components);
  return dimension;
}

}  // namespace binnacle::results
