// SPDX-License-Identifier: Apache-2.0
#include "covariance_text.hpp"

#include <fmt/format.h>

#include "study_text.hpp"
#include "table.hpp"

namespace binnacle::command {

namespace {

std::string metrics_text(const Json& summary, const study::Study& study) {
  std::string text;
  for (const auto& metric : study.metrics()) {
    Table table("lr");
    table.row({metric.name + (metric.unit == "1" ? "" : " [" + metric.unit + "]"), ""});
    for (const auto& [name, variant] : summary.at("variants").items()) {
      if (!variant.at("metrics").contains(metric.name)) continue;
      const Json& value = variant.at("metrics").at(metric.name).at("mean");
      table.row({name, value.is_number() ? fmt::format("{:.4f}", value.get<double>()) : "-"});
    }
    text += table.text() + "\n";
  }
  return text;
}

/// Shares of the variance, in percent.
std::string budget_text(const Json& summary) {
  std::string text;
  for (const auto& [name, variant] : summary.at("variants").items())
    for (const auto& [output, shares] : variant.at("budget").items()) {
      Table table("lr");
      table.row({name + ": " + output + ", share of the final variance", "%"});
      for (const auto& [source, share] : shares.items())
        table.row({source, share.is_number() ? fmt::format("{:.2f}", 100 * share.get<double>()) : "-"});
      text += table.text() + "\n";
    }
  return text;
}

}  // namespace

std::string covariance_text(const Json& summary, const study::Study& study, bool has_budget) {
  const std::string title = heading(study.title());
  return title + metrics_text(summary, study) + tables_text(summary, study) + (has_budget ? budget_text(summary) : "");
}

}  // namespace binnacle::command
