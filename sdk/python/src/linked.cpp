// SPDX-License-Identifier: Apache-2.0
#include "linked.hpp"

#include <algorithm>
#include <array>

#include "arrays.hpp"
#include "binnacle/version.hpp"

namespace binnacle::python {

std::vector<std::shared_ptr<const LinkedPlugin>> linked_plugins() {
  // Not "python", which models written in Python are of: these are compiled.
  static const auto arrays =
      std::make_shared<const LinkedPlugin>(LinkedPlugin{"numpy", BINNACLE_VERSION, &add_array_types});
  return {arrays};
}

bool wants_arrays(const std::string& config_text) {
  const std::array names{"\"numpy/", "\"arrays\"", "\"keep\""};
  return std::ranges::any_of(names, [&](const char* name) { return config_text.find(name) != std::string::npos; });
}

}  // namespace binnacle::python
