// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "binnacle/unit.hpp"
#include "payload.hpp"

namespace binnacle::report {

namespace {

/// A distribution is drawn by no more than this many of its quantiles.
constexpr std::size_t most_quantiles = 401;

/// Sorted; of more than that, evenly many quantiles, least and greatest included.
std::vector<double> distribution(const results::StudyResults& study, std::size_t variant, std::size_t metric,
                                 double scale) {
  std::vector<double> values;
  for (std::size_t run = 0; run < study.runs; ++run) {
    const double value = study.values[(variant * study.metrics.size() + metric) * study.runs + run];
    if (std::isfinite(value)) values.push_back(value / scale);
  }
  std::sort(values.begin(), values.end());
  if (values.size() <= most_quantiles) return values;
  std::vector<double> quantiles;
  for (std::size_t i = 0; i < most_quantiles; ++i)
    quantiles.push_back(values[(values.size() - 1) * i / (most_quantiles - 1)]);
  return quantiles;
}

}  // namespace

Json study_payload(const results::StudyResults& study, Columns& columns) {
  Json json{{"figures", study.figures},
            {"config", study.config},
            {"provenance", study.provenance},
            {"runs", study.runs}};
  json["variants"] = study.variants;
  json["metrics"] = Json::array();
  for (std::size_t m = 0; m < study.metrics.size(); ++m) {
    const auto& metric = study.metrics[m];
    // In the metric's own unit, whatever it is: the figures beside it are in that.
    const auto shown = parse_unit(metric.unit), si = parse_unit(metric.si_unit);
    const double scale = shown && si ? shown->scale / si->scale : 1;
    Json entry{{"name", metric.name}, {"unit", metric.unit == "1" ? "" : metric.unit}, {"values", Json::array()}};
    for (std::size_t v = 0; v < study.variants.size(); ++v)
      entry["values"].push_back(columns.plotted(distribution(study, v, m, scale)));
    json["metrics"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace binnacle::report
