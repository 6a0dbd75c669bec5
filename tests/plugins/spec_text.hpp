// SPDX-License-Identifier: Apache-2.0
// Texts of a spec.
#pragma once

#include <string>
#include <vector>

#include "binnacle/spec.hpp"

namespace binnacle::test {

/// Everything in a spec that documentation needs is there, down to nested parameters.
inline std::string undocumented(const std::vector<ParameterSpec>& parameters, const std::string& where = {}) {
  for (const auto& parameter : parameters) {
    const std::string pointer = where + "/" + parameter.name;
    if (parameter.name.empty() || (parameter.text.empty() && where.empty())) return pointer;
    const bool is_element = parameter.type == ParameterType::map || parameter.type == ParameterType::list;
    if (!is_element)
      for (const auto& member : parameter.members)
        if (member.text.empty()) return pointer + "/" + member.name;
    for (const auto& member : parameter.members)
      if (const auto missing = undocumented(member.members, pointer + "/" + member.name); !missing.empty())
        return missing;
  }
  return {};
}

}  // namespace binnacle::test
