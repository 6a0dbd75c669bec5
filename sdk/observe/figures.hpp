// SPDX-License-Identifier: Apache-2.0
// What a window showed, as JSON: components by name, in the units that people read.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "observe/directions.hpp"
#include "observe/window.hpp"
#include "one_path.hpp"

namespace binnacle::observe {

/// A row of P.
struct RowName {
  std::string name;  // "attitude.down"
  std::string unit;  // for display
  double scale = 1;  // of that unit [SI]
  bool is_considered = false;
};

/// By row of P.
std::vector<RowName> rows_of(const FilterInfo& filter);

/// One of the list that Observability::figures() has by filter.
nlohmann::ordered_json figures_of(const Stay& stay, const OnePath& path, const FilterInfo& filter);

}  // namespace binnacle::observe
