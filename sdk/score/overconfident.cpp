// SPDX-License-Identifier: Apache-2.0
#include "overconfident.hpp"

#include <cstdio>

#include "chi_squared_score.hpp"

namespace binnacle::score {

std::string overconfident(const nlohmann::ordered_json& consistency) {
  double most = rare_score;
  std::string text;
  for (const auto& [name, entry] : consistency.items()) {
    const double nees = entry.at("nees_mean"), dof = entry.at("dof");
    if (!(dof > 0) || (name == "state" && !text.empty())) continue;  // a block says more; the state comes last
    const double score = chi_squared_score(nees / dof, dof);
    if (!(score > most)) continue;
    most = score;
    char figures[64];
    std::snprintf(figures, sizeof figures, "%.3g over %.3g degrees of freedom", nees, dof);
    text = "NEES of '" + name + "' is " + figures +
           ": P is too small for these errors, or the reference is less accurate than the filter";
  }
  return text;
}

}  // namespace binnacle::score
