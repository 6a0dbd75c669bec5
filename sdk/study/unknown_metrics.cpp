// SPDX-License-Identifier: Apache-2.0
// A metric that one variant lacks and another has goes without saying; one that none of them has is misspelt.
#include <algorithm>

#include <nlohmann/json.hpp>

#include "score/metric.hpp"
#include "score/sections.hpp"
#include "study/section.hpp"
#include "study/variants.hpp"

namespace binnacle::study {

namespace {

bool is_entry(const Json& entry, const std::string& name) {
  return entry == Json(name) || (entry.is_object() && entry.contains("metric") && entry.at("metric") == Json(name));
}

/// Whether the variant's "evaluate" has the metric, misspelt or not.
bool lists(const Composition& composition, const std::string& name) {
  const Json::json_pointer place("/evaluate/metrics");
  const Json config = Json::parse(composition.config());
  if (!config.contains(place)) return false;
  const Json& metrics = config.at(place);
  if (!metrics.is_array()) return is_entry(metrics, name);
  return std::any_of(metrics.begin(), metrics.end(), [&](const Json& entry) { return is_entry(entry, name); });
}

bool knows(const Composition& composition, const std::string& name) {
  const auto unknown = score::unknown_metrics(composition);
  return lists(composition, name) &&
         std::none_of(unknown.begin(), unknown.end(), [&](const auto& metric) { return metric.name == name; });
}

}  // namespace

Diagnostics misspelt_metrics(const Composition& variant,
                             const std::vector<std::shared_ptr<const Composition>>& variants,
                             const std::filesystem::path& path, const LoadOptions& options) {
  Diagnostics errors;
  const auto unknown = score::unknown_metrics(variant);
  if (unknown.empty()) return errors;
  const Config config = score::load_config(path, options);
  for (const auto& metric : unknown)
    if (std::none_of(variants.begin(), variants.end(), [&](const auto& other) { return knows(*other, metric.name); }))
      errors.error("B027", config.origin(metric.pointer), metric.pointer, metric.error);
  return errors;
}

void refuse_misspelt_metrics(const Composition& variant, const std::filesystem::path& path,
                             const LoadOptions& options) {
  if (score::unknown_metrics(variant).empty()) return;
  LoadOptions load = options;
  load.patches.clear();
  Diagnostics ignored;
  std::vector<std::shared_ptr<const Composition>> variants;
  for (const auto& entry : variants_of(score::load_config(path, load), ignored)) {
    load.patches = entry.patches;
    try {
      variants.push_back(score::load(path, load));
    } catch (const Error&) {
      // Another variant's mistakes are for `check`.
    }
  }
  const Diagnostics errors = misspelt_metrics(variant, variants, path, options);
  if (errors.has_errors()) throw ConfigError(errors);
}

}  // namespace binnacle::study
